"""Two smoothers in one equation: the polynomials of `Smoother`, the Gaussian of the diagnosis, of the same cut-off.

    python benchmarks/smoothers.py -o benchmarks/results/smoothers.json

A simulated carriage with dry friction, whose equation ``m a + F sgn(v) = tau`` holds exactly. As in the diagnosis, a
first filter smooths what was measured, the law is evaluated after it, and a second filter smooths every term. What is
left of the equation is the error of the filters, and behind noise that of the noise.
"""

from __future__ import annotations

import sys
from typing import Any

import numpy as np
from measure import arguments, conclude
from noise_estimators import RATE, Array, motion
from scipy.optimize import brentq

import flexdyn as fd
from flexdyn.diagnose.data.filters import FIRST_FILTER_WIDTH, SECOND_FILTER_WIDTHS
from flexdyn.records.signals.kernels import GaussianSmoother

MASS, LEVEL = 95.1089, 20.3
"""Of the carriage [kg, N]."""
NOISES = (0.0, 1e-7, 1e-6)
"""Standard deviations of the encoder's noise [m]."""
EDGE = 300
"""Samples at either end that are left out, the same for all filters."""


def cutoff(gaussian: GaussianSmoother) -> float:
    """Frequency at which the response is 1/sqrt(2) [Hz]."""
    places = np.arange(-gaussian.half, gaussian.half + 1)
    found = brentq(
        lambda f: gaussian.taps[0] @ np.cos(2.0 * np.pi * f * places / RATE) - 0.5**0.5, 0.1, 0.5 * RATE - 1.0
    )
    return float(found)


def by_gaussians(q: Array, tau: Array, level: float, first: GaussianSmoother, second: GaussianSmoother) -> Array:
    """What is left of the equation behind two Gaussians; the held torque is centred before."""
    centred = np.concatenate([tau[:1], 0.5 * (tau[1:] + tau[:-1])])
    left = MASS * first.apply(q, 2) + level * np.sign(first.apply(q, 1)) - first.apply(centred, 0)
    return _inner(second.apply(left, 0), first.half + second.half)


def by_polynomials(q: Array, tau: Array, level: float, first: fd.Smoother, second: fd.Smoother) -> Array:
    """The same behind two smoothers for users."""
    left = MASS * first.second(q) + level * np.sign(first.first(q)) - first.held(tau)
    return _inner(second.value(left), first.reach + second.reach)


def _inner(left: Array, lost: int) -> Array:
    return left[EDGE - lost : len(left) - (EDGE - lost)]


def overshoot(value: Array) -> float:
    """Largest value beyond a step behind a kernel, over the step [1]."""
    return float(np.cumsum(value).max() - 1.0)


def compared(level: float, width: float) -> dict[str, Any]:
    """Both filters over one motion, for several sizes of noise.

    Args:
        level: of the dry friction [N].
        width: standard deviation of the second Gaussian [s].
    """
    run = motion(level)
    q, tau = run.q[:, 0], run.tau[:, 0]
    gaussians = [GaussianSmoother.of_width(each, 1.0 / RATE) for each in (FIRST_FILTER_WIDTH, width)]
    polynomials = [fd.Smoother.at_cutoff(cutoff(each), RATE) for each in gaussians]
    rows = []
    for std in NOISES:
        seen = q + std * np.random.default_rng(0).normal(size=len(q))
        left = by_gaussians(seen, tau, level, *gaussians), by_polynomials(seen, tau, level, *polynomials)
        rows.append({"noise": std, "rms": [float(np.sqrt(np.mean(each**2))) for each in left]})
    return {
        "cutoff": [cutoff(gaussians[1]), polynomials[1].cutoff],
        "samples": [2 * gaussians[1].half + 1, 2 * polynomials[1].reach + 1],
        "overshoot": [overshoot(gaussians[1].taps[0]), overshoot(polynomials[1]._kernels.value)],
        "left": rows,
    }


def main() -> int:
    """Measure, print and write."""
    given = arguments(__doc__).parse_args()
    content = {
        "torque_rms": float(np.sqrt(np.mean(motion(LEVEL).tau ** 2))),
        "cases": {
            f"{name}, {1e3 * width:g} ms": compared(level, width)
            for name, level in (("smooth motion", 0.0), ("dry friction", LEVEL))
            for width in (SECOND_FILTER_WIDTHS[0], SECOND_FILTER_WIDTHS[-1])
        },
    }
    return conclude([], given.output, "smoothers.py", content)


if __name__ == "__main__":
    sys.exit(main())
