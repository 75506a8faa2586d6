"""The noise of recorded channels, estimated from the recordings alone."""

from __future__ import annotations

import numpy as np

from flexdyn.arrays import Array
from flexdyn.diagnose.data.measured import Measured
from flexdyn.records.signals.reading_noise import high_frequency_std


def encoder_noise(data: tuple[Measured, ...], signal: str) -> Array:
    """Standard deviation of each joint's encoder (n,) [rad or m]: of its steps, or of parts that no motion explains."""
    return np.asarray(np.max([getattr(each, f"{signal}_noise") for each in data], axis=0))


def recorded_torque_noise(data: tuple[Measured, ...]) -> Array:
    """Standard deviation of the changes of each recorded torque from sample to sample (n,) [N m or N].

    It is larger than the noise if a controller amplifies the noise of its encoders, because this torque is real.
    """
    return np.array([max(high_frequency_std(each.tau[:, j]) for each in data) for j in range(data[0].tau.shape[1])])
