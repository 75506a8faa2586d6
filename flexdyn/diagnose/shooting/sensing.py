"""Sensor effects of a model, applied to simulated signals, and removed from measured ones."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from flexdyn.arrays import Array
from flexdyn.effects import SensorEffect
from flexdyn.effects.channels import by_channel, instant, lag, recovered
from flexdyn.model.flexible_joint_model import FlexibleJointModel
from flexdyn.records import Recording

Law = Callable[[Sequence[SensorEffect], Array, Array], Array]


def sensors(model: FlexibleJointModel, channel: str) -> tuple[SensorEffect, ...]:
    """The effects of a model on a channel that are not neutral."""
    return tuple(by_channel(model.resolved().effects).get(channel, ()))


def true_samples(model: FlexibleJointModel, recording: Recording, channel: str) -> tuple[Array, Array]:
    """What a recorded channel measures: times without its lag [s], and values without its sensor effects."""
    effects = sensors(model, channel)
    return recording.t - lag(effects), recovered(effects, recording[channel], recording.t)


def early(recording: Recording, channel: str, late: float, t: Array) -> Array:
    """A recorded channel without its lag: its later value, by a cubic spline; NaN beyond its end.

    Args:
        recording: that has it.
        channel: its name.
        late: its lag [s].
        t: times, of any shape [s].
    """
    from scipy.interpolate import CubicSpline

    when = t + late
    return np.where(when <= recording.t[-1], CubicSpline(recording.t, recording[channel])(when), np.nan)


def of_windows(law: Law, effects: Sequence[SensorEffect], x: Array, t: Array) -> Array:
    """Evaluate a law of samples, `measure` or its `slope`, over independent windows, without the lag (see `early`).

    Args:
        law: of effects, samples and times.
        effects: on the channel.
        x: of all windows (windows, samples).
        t: their times, likewise [s].
    """
    effects = instant(effects)
    if all(type(effect).measured is SensorEffect.measured for effect in effects):  # every sample by itself
        return law(effects, x.ravel(), t.ravel()).reshape(x.shape)
    return np.stack([law(effects, *each) for each in zip(x, t, strict=True)])
