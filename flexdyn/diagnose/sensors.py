"""Measured channels put right: what a model's sensor effects added is taken off again."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

from flexdyn.diagnose.measured import Measured
from flexdyn.effects import ChannelLag, EncoderEccentricity, SensorEffect, SensorGain, SensorOffset
from flexdyn.model import FlexibleJointModel

Array = NDArray[np.float64]
ROUNDS, SETTLED = 20, 1e-15
"""Rounds for the angle under an eccentric disc, at most, and the change that is none [rad]."""


def corrected(data: Measured, model: FlexibleJointModel) -> Measured:
    """The true channels behind measured ones, if the model's sensor effects are right."""
    effects = [e for e in model.effects if isinstance(e, SensorEffect) and not e.is_neutral]
    if not effects:
        return data
    columns = {signal: getattr(data, signal).copy() for signal in ("q", "theta", "tau", "tau_s")}
    for channel in {e.channel for e in effects}:
        signal, _, joint = channel.partition(".")
        if signal in columns:
            j = model.index(joint)
            acting = [e for e in effects if e.channel == channel]
            columns[signal][:, j] = true_channel(acting, columns[signal][:, j], data.dt)
    return dataclasses.replace(data, **columns)


def true_channel(effects: Iterable[SensorEffect], measured: Array, dt: float) -> Array:
    """The channel that these effects make the measured one of; the inverse of `flexdyn.effects.measure`.

    Offset and gain first, then eccentricity by fixed-point iteration, then the lag by cubic interpolation.
    """
    effects = list(effects)
    offset = sum(e.offset for e in effects if isinstance(e, SensorOffset))
    gain = sum(e.gain for e in effects if isinstance(e, SensorGain))
    x = (measured - offset) / (1.0 + gain)
    discs = [e for e in effects if isinstance(e, EncoderEccentricity)]
    if discs:
        seen = x
        for _ in range(ROUNDS):  # amplitude times harmonic is far below 1: each round gains that factor
            before, x = x, seen - np.sum([e.error(x) for e in discs], axis=0)
            if np.abs(x - before).max(initial=0.0) < SETTLED:
                break
    delay = sum(e.delay for e in effects if isinstance(e, ChannelLag))
    return advanced(x, delay, dt) if delay else x


def advanced(x: Array, delay: float, dt: float) -> Array:
    """x(t + delay) [s] at the samples of x, by a cubic spline; the last values are extrapolated by the last sample."""
    from scipy.interpolate import CubicSpline

    t = dt * np.arange(len(x))
    return np.asarray(CubicSpline(t, x)(np.minimum(t + delay, t[-1])))
