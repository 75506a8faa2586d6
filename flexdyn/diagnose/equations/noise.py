"""The noise of the channels, estimated from the data."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from flexdyn.diagnose.data.measured import Measured
from flexdyn.diagnose.equations.covariance import SampleNoise, variances
from flexdyn.diagnose.equations.equations import MOTOR, TOTAL, Equations
from flexdyn.records.signals.noise_spectrum import GAUSS

Array = NDArray[np.float64]
DIFFERENCE = np.array([1.0, -6.0, 15.0, -20.0, 15.0, -6.0, 1.0])
"""Coefficients of the sixth difference."""
ENCODER_NOISE_SHARE = 0.5
"""Share of the residual's noise that encoders may make for the torque's to be told from it."""


def encoder_noise(data: tuple[Measured, ...], signal: str) -> Array:
    """Standard deviation of each joint's encoder (n,) [rad or m]: of its steps, or of parts that no motion explains."""
    n = getattr(data[0], signal).shape[1]
    return np.array([max(_of_channel(getattr(each, signal)[:, j]) for each in data) for j in range(n)])


def _of_channel(x: Array) -> float:
    steps = np.abs(np.diff(x))
    moved = steps[steps > 0.0]
    if not len(moved):
        return 0.0
    step = float(moved.min())
    ratio = moved / step
    counted = np.mean(np.abs(ratio - np.round(ratio)) < 0.01) > 0.99
    quantised = step / np.sqrt(12.0) if counted else 0.0
    return max(float(quantised), _rough(x))


def _rough(x: Array) -> float:
    """Standard deviation of the part that changes from sample to sample (samples,)."""
    high = np.convolve(x, DIFFERENCE, "valid") / np.linalg.norm(DIFFERENCE)
    return GAUSS * float(np.median(np.abs(high - np.median(high))))


def recorded_torque_noise(data: tuple[Measured, ...]) -> Array:
    """Standard deviation of the changes of each recorded torque from sample to sample (n,) [N m or N].

    It is larger than the noise if a controller amplifies the noise of its encoders, because this torque is real.
    """
    return np.array([max(_rough(each.tau[:, j]) for each in data) for j in range(data[0].tau.shape[1])])


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
        seen = (GAUSS * float(np.median(np.abs(second[clear] - np.median(second[clear]))))) ** 2
        others, unit = variances(equations, encoders, place, j)
        if others > ENCODER_NOISE_SHARE * seen:
            found[j] = recorded_torque_noise(equations.data)[j]
        else:
            found[j] = np.sqrt((seen - others) / unit)
    return found
