"""Corrected channels: the sensor effects of a model are removed from the measured channels."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence

import numpy as np

from flexdyn.arrays import Array
from flexdyn.diagnose.data.measured import SIGNALS, Measured
from flexdyn.effects import SensorEffect
from flexdyn.effects.channels import by_channel, lag, recovered
from flexdyn.model.flexible_joint_model import FlexibleJointModel

SPARE_SAMPLES = 16
"""Number of samples beyond either end that have an influence on a spline's coefficients."""


def true_channels(data: Measured, model: FlexibleJointModel) -> Measured:
    """The true channels, if the model's sensor effects are right."""
    sensors = by_channel(model.effects)
    if not sensors:
        return data
    columns = {signal: getattr(data, signal).copy() for signal in SIGNALS}
    for channel, effects in sensors.items():
        signal, _, joint = channel.partition(".")
        if signal in columns:
            j = model.index(joint)
            columns[signal][:, j] = true_channel(effects, columns[signal][:, j], data)
    return dataclasses.replace(data, **columns)


def true_channel(effects: Sequence[SensorEffect], measured: Array, data: Measured) -> Array:
    """The channel that these effects make the measured one of; the lag is undone last, by cubic interpolation."""
    x, delay = recovered(effects, measured, data.t), lag(effects)
    return advanced(x, delay, data.dt) if delay else x


def advanced(x: Array, delay: float, dt: float) -> Array:
    """x(t + delay) [s] at the samples of x, by a cubic spline; beyond the ends it is the first and the last value.

    On a regular clock the spline is its B-spline coefficients passed through four taps (Unser et al., 1993).
    """
    from scipy.ndimage import spline_filter1d

    whole, part = divmod(delay / dt, 1.0)
    count = len(x)
    coefficients = spline_filter1d(np.pad(x, SPARE_SAMPLES, mode="reflect", reflect_type="odd"), order=3)
    taps = np.array([(1 - part) ** 3, 4 - 6 * part**2 + 3 * part**3, 1 + 3 * part * (1 + part - part**2), part**3]) / 6
    between = np.convolve(coefficients[SPARE_SAMPLES - 1 : SPARE_SAMPLES + count + 2], taps[::-1], "valid")
    at = np.arange(count) + int(np.clip(whole, -count, count))
    return np.where(at + part > count - 1.0, x[-1], between[np.clip(at, 0, count - 1)])
