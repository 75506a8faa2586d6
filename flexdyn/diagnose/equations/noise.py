"""The noise of the channels, estimated from the data."""

from __future__ import annotations

import math

import numpy as np

from flexdyn.arrays import Array, Flags
from flexdyn.diagnose.data.channel_noise import recorded_torque_noise
from flexdyn.diagnose.equations.covariance import SampleNoise, row_variances
from flexdyn.diagnose.equations.equations import Equations
from flexdyn.diagnose.equations.layout import MOTOR, TOTAL
from flexdyn.diagnose.equations.noise_coefficients import freest
from flexdyn.records.signals.reading_noise import robust_std

ENCODER_NOISE_SHARE = 0.5
"""Share of the residual's noise that encoders may make for the torque's to be told from it."""
WIDEST_SEARCH = 3.0
"""Logarithm of a ratio within which the level of a noise is sought: of the size of its rows [1]."""


def torque_noise(equations: Equations, left: Array, mask: Flags, encoders: SampleNoise) -> Array:
    """Standard deviation of each joint's torque channel (n,) [N m or N].

    Second differences of the residuals contain noise and hardly any missing effect. Beside the part of the encoders it
    is noise of the torque, in the recording or at the motor. Rows differ in how much they show: where friction takes a
    share of the load, those with a driving motor less than the others. If the encoders cause most of it, as
    with a missing encoder, or where a limit of the motor cuts all of it, the changes of the recorded torque from sample
    to sample are used instead.

    Args:
        equations: of the fitted model.
        left: their residuals, not whitened (rows,).
        mask: rows that are not used.
        encoders: noise, with a torque noise of 1 for each joint.
    """
    many = len(equations.kinds)
    rows, hidden = left.reshape(-1, many), mask.reshape(-1, many)
    found = np.zeros(equations.true.n)
    for place, (j, kind) in enumerate(equations.kinds):
        if kind not in (MOTOR, TOTAL):
            continue
        second = rows[2:, place] - 2.0 * rows[1:-1, place] + rows[:-2, place]
        free = np.concatenate([freest(equations, along, j) for along in equations.motions])
        shut = hidden[:, place] | ~free
        clear = ~(shut[2:] | shut[1:-1] | shut[:-2])
        if clear.sum() < 20:
            clear[:] = True
        parts = [row_variances(equations, along, encoders, place, j, second=True) for along in equations.motions]
        others, unit = (np.concatenate(each)[1:-1][clear] for each in zip(*parts, strict=True))
        seen = robust_std(second[clear]) ** 2
        if np.median(others) > ENCODER_NOISE_SHARE * seen or np.median(unit) <= 0.0:
            found[j] = recorded_torque_noise(equations.data)[j]
        else:
            found[j] = _level(second[clear], others, unit, np.sqrt(seen / np.median(unit)))
    return found


def _level(seen: Array, others: Array, unit: Array, first: float) -> float:
    """Level s at which values are as large as their variances ``others + unit s^2`` say, by the bulk of them.

    Args:
        seen: values whose variances differ (values,).
        others: variances from other channels (values,).
        unit: variances for s = 1 (values,).
        first: a level from which the right one is not far.
    """
    from scipy.optimize import brentq

    def too_large(log_level: float) -> float:
        """Spread of the values over what a level says, less 1."""
        variance = others + unit * math.exp(2.0 * log_level)
        return robust_std(seen / np.sqrt(np.maximum(variance, 1e-300))) - 1.0

    low, high = math.log(first) - WIDEST_SEARCH, math.log(first) + WIDEST_SEARCH
    if too_large(low) <= 0.0 or too_large(high) >= 0.0:
        return first
    return math.exp(brentq(too_large, low, high, xtol=1e-4))
