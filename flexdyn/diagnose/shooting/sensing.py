"""Sensor effects of a model, applied to simulated signals, and removed from measured ones."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

import numpy as np

from flexdyn.arrays import Array
from flexdyn.effects import SensorEffect, measure
from flexdyn.model.flexible_joint_model import FlexibleJointModel
from flexdyn.records import Recording

Law = Callable[[Sequence[SensorEffect], Array, Array], Array]


def sensors(model: FlexibleJointModel, channel: str) -> tuple[SensorEffect, ...]:
    """The effects of a model on a channel that are not neutral."""
    effects = (effect for effect in model.resolved().effects if isinstance(effect, SensorEffect))
    return tuple(effect for effect in effects if effect.channel == channel and not effect.is_neutral)


def lag(effects: Sequence[SensorEffect]) -> float:
    """The lag of a channel [s]."""
    return math.fsum(effect.lateness for effect in effects)


def seen(effects: Sequence[SensorEffect], x: Array, t: Array) -> Array:
    """A simulated channel as the sensor reports it, without its lag (see `early`)."""
    return measure([effect for effect in effects if not effect.lateness], x, t)


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


def slope(effects: Sequence[SensorEffect], x: Array, t: Array) -> Array:
    """Derivative of a reported channel by the true one, without its lag [1]."""
    instant = [effect for effect in effects if not effect.lateness]
    step = 1e-6
    return (measure(instant, x + step, t) - measure(instant, x - step, t)) / (2.0 * step)


def of_windows(law: Law, effects: Sequence[SensorEffect], x: Array, t: Array) -> Array:
    """Evaluate a law of samples, such as `seen` or `slope`, over independent windows.

    Args:
        law: of effects, samples and times.
        effects: on the channel.
        x: of all windows (windows, samples).
        t: their times, likewise [s].
    """
    if all(type(effect).measured is SensorEffect.measured for effect in effects):  # every sample by itself
        return law(effects, x.ravel(), t.ravel()).reshape(x.shape)
    return np.stack([law(effects, *each) for each in zip(x, t, strict=True)])
