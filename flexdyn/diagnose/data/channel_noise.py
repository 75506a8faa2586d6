"""The noise of recorded channels, estimated from the recordings alone."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from flexdyn.diagnose.data.measured import Measured
from flexdyn.records.signals.noise_spectrum import GAUSS

Array = NDArray[np.float64]
DIFFERENCE = np.array([1.0, -6.0, 15.0, -20.0, 15.0, -6.0, 1.0])
"""Coefficients of the sixth difference."""


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
