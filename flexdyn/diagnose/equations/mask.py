"""Rows that say nothing: where a velocity has no certain sign, dry friction may be anything between its levels."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from flexdyn.diagnose.equations.covariance import SampleNoise
from flexdyn.diagnose.equations.equations import LINK, MOTOR, SENSOR, TOTAL, Equations
from flexdyn.diagnose.equations.motion import SmoothedMotion

Array = NDArray[np.float64]
CERTAIN_SIGN_SIGMAS = 5.0
"""A velocity of fewer standard deviations than this has no certain sign."""


def sign_mask(equations: Equations, noise: SampleNoise, *, alone: bool = False) -> NDArray[np.bool_]:
    """Rows (rows,) whose filters reach an instant at which a velocity of their joint has no certain sign.

    Args:
        equations: whose rows they are.
        noise: of the encoders.
        alone: whether joints with a made-up position hide no rows of other joints.
    """
    found = []
    for along in equations.motions:
        at = equations.filters.instants(len(along.t))
        hidden = np.zeros((len(at), len(equations.kinds)), dtype=bool)
        unseen = [] if alone else [(int(i), TOTAL) for i in np.flatnonzero(equations.made_up)]
        for place, (j, kind) in enumerate(equations.kinds):
            if kind != SENSOR:
                # A made-up position lacks its own joint's stuck friction, and loads every other equation with it.
                for i, of in {(j, kind), *unseen}:
                    hidden[:, place] |= _uncertain(equations, along, noise, i, of)[at]
        found.append(hidden.ravel())
    return np.concatenate(found)


def _uncertain(equations: Equations, along: SmoothedMotion, noise: SampleNoise, j: int, kind: str) -> NDArray[np.bool_]:
    """Samples from which an uncertain sign is within reach of the filters."""
    filters = equations.filters
    data = along.data
    spread = float(np.linalg.norm(filters.first.taps[1]))
    uncertain = np.zeros(len(along.t), dtype=bool)
    for side, u, level, there in (
        (MOTOR, along.omega[:, j], noise.theta[j], data.has_theta[j]),
        (LINK, along.v[:, j], noise.q[j], data.has_q[j]),
    ):
        if kind in (MOTOR, LINK) and kind != side:
            continue
        sigma = level if there else max(noise.q[j], noise.theta[j]) * 3.0
        uncertain |= np.abs(u) <= CERTAIN_SIGN_SIGMAS * spread * sigma  # 0 has none, however good the encoder
        uncertain[1:] |= u[1:] * u[:-1] < 0.0
    passes = 1 + (along.lost > filters.first.half)
    reach = round(0.6 * (passes * filters.first.half + filters.second.half))  # three standard deviations of each
    return np.convolve(uncertain, np.ones(2 * reach + 1), "same") > 0.5
