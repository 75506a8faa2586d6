"""Masked rows: where the sign of a velocity is uncertain, dry friction can have any value between its levels."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from flexdyn.diagnose.equations.covariance import SampleNoise
from flexdyn.diagnose.equations.equations import LINK, MOTOR, SENSOR, TOTAL, Equations
from flexdyn.diagnose.equations.motion import SmoothedMotion
from flexdyn.effects import JointCoupling

Array = NDArray[np.float64]
CERTAIN_SIGN_SIGMAS = 5.0
"""The sign of a velocity below this number of standard deviations is uncertain [1]."""


def sign_mask(equations: Equations, noise: SampleNoise, *, alone: bool = False) -> NDArray[np.bool_]:
    """Rows (rows,) whose filters cover an instant at which the sign of a velocity of their joint is uncertain.

    Args:
        equations: that have the rows.
        noise: of the encoders.
        alone: whether joints with a computed position do not mask rows of other joints.
    """
    found = []
    for along in equations.motions:
        at = equations.filters.instants(len(along.t))
        hidden = np.zeros((len(at), len(equations.kinds)), dtype=bool)
        unseen = [] if alone else [(int(i), TOTAL) for i in np.flatnonzero(equations.made_up)]
        for place, (j, kind) in enumerate(equations.kinds):
            if kind != SENSOR:
                # A computed position lacks the friction of its sticking joint; the error enters every other equation.
                for i, of in {(j, kind), *unseen}:
                    hidden[:, place] |= _uncertain(equations, along, noise, i, of)[at]
                    if of in (MOTOR, TOTAL):
                        hidden[:, place] |= _rubbing(equations, along, noise, i)[at]
        found.append(hidden.ravel())
    return np.concatenate(found)


def _uncertain(equations: Equations, along: SmoothedMotion, noise: SampleNoise, j: int, kind: str) -> NDArray[np.bool_]:
    """Samples whose filters cover an uncertain sign."""
    data = along.data
    spread = float(np.linalg.norm(equations.filters.first.taps[1]))
    uncertain = np.zeros(len(along.t), dtype=bool)
    for side, u, level, there in (
        (MOTOR, along.omega[:, j], noise.theta[j], data.has_theta[j]),
        (LINK, along.v[:, j], noise.q[j], data.has_q[j]),
    ):
        if kind in (MOTOR, LINK) and kind != side:
            continue
        sigma = level if there else max(noise.q[j], noise.theta[j]) * 3.0
        uncertain |= _without_sign(u, spread * sigma)
    return _covered(equations, along, uncertain)


def _rubbing(equations: Equations, along: SmoothedMotion, noise: SampleNoise, j: int) -> NDArray[np.bool_]:
    """The same of the relative velocities of a motor and of others that rub on it."""
    true, uncertain = equations.true, np.zeros(len(along.t), dtype=bool)
    spread, levels = float(np.linalg.norm(equations.filters.first.taps[1])), np.maximum(noise.q, noise.theta)
    for effect in true.all_effects:
        if isinstance(effect, JointCoupling) and effect.level > 0.0:
            one, other = true.index(effect.joint), true.index(effect.other)
            if j in (one, other):
                u = along.omega[:, one] - effect.ratio * along.omega[:, other]
                uncertain |= _without_sign(u, spread * float(np.hypot(levels[one], effect.ratio * levels[other])))
    return _covered(equations, along, uncertain)


def _without_sign(u: Array, sigma: float) -> NDArray[np.bool_]:
    """Samples at which a velocity (samples,) has no certain sign; that of 0 is always uncertain."""
    uncertain = np.abs(u) <= CERTAIN_SIGN_SIGMAS * sigma
    uncertain[1:] |= u[1:] * u[:-1] < 0.0
    return np.asarray(uncertain)


def _covered(equations: Equations, along: SmoothedMotion, uncertain: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Samples whose filters cover an uncertain one."""
    filters = equations.filters
    passes = 1 + (along.lost > filters.first.half)
    reach = round(0.6 * (passes * filters.first.half + filters.second.half))  # three standard deviations of each
    return np.convolve(uncertain, np.ones(2 * reach + 1), "same") > 0.5
