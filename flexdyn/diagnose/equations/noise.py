"""The noise of the channels, estimated from the data."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from flexdyn.diagnose.data.measured import Measured
from flexdyn.diagnose.equations.covariance import SampleNoise, variances
from flexdyn.diagnose.equations.equations import MOTOR, TOTAL, Equations
from flexdyn.records.signals.reading_noise import high_frequency_std, reading_noise, robust_std

Array = NDArray[np.float64]
ENCODER_NOISE_SHARE = 0.5
"""Share of the residual's noise that encoders may make for the torque's to be told from it."""


def encoder_noise(data: tuple[Measured, ...], signal: str) -> Array:
    """Standard deviation of each joint's encoder (n,) [rad or m]: of its steps, or of parts that no motion explains."""
    n = getattr(data[0], signal).shape[1]
    return np.array([max(reading_noise(getattr(each, signal)[:, j]) for each in data) for j in range(n)])


def recorded_torque_noise(data: tuple[Measured, ...]) -> Array:
    """Standard deviation of the changes of each recorded torque from sample to sample (n,) [N m or N].

    It is larger than the noise if a controller amplifies the noise of its encoders, because this torque is real.
    """
    return np.array([max(high_frequency_std(each.tau[:, j]) for each in data) for j in range(data[0].tau.shape[1])])


def torque_noise(equations: Equations, left: Array, mask: NDArray[np.bool_], encoders: SampleNoise) -> Array:
    """Standard deviation of each joint's torque channel (n,) [N m or N].

    Second differences of the residuals contain noise and hardly any missing effect. The part of the encoders is
    subtracted; the rest is noise of the torque, in the recording or at the motor. If the encoders cause most of it, as
    with a missing encoder, the changes of the recorded torque from sample to sample are used instead.

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
        clear = ~(hidden[2:, place] | hidden[1:-1, place] | hidden[:-2, place])
        if clear.sum() < 20:
            clear[:] = True
        seen = robust_std(second[clear]) ** 2
        others, unit = variances(equations, encoders, place, j)
        if others > ENCODER_NOISE_SHARE * seen:
            found[j] = recorded_torque_noise(equations.data)[j]
        else:
            found[j] = np.sqrt((seen - others) / unit)
    return found
