"""All sensor effects of a channel together: what the sensor reports of the true channel, and the inverse of that."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterable

import numpy as np
from numpy.typing import ArrayLike

from flexdyn.arrays import Array
from flexdyn.effects.base import Effect
from flexdyn.effects.sensor import ChannelLag, EncoderEccentricity, SensorEffect, SensorGain, SensorOffset

DISC_ROUNDS, DISC_ROUNDING = 20, 4.0
"""Rounds for the angle under an eccentric disc, at most, and the change that is rounding [units of the last place]."""
NEWTON_ROUNDS, NEWTON_ROUNDING = 30, 1e-14
"""Steps of Newton's method, at most, and the share of the largest value below which a step is rounding."""
SLOPE_STEP, SMALLEST_SLOPE = 1e-6, 0.05
"""Step of the differences by which slopes are taken, and the slope below which Newton's method takes 1 instead."""

_ORDER = (ChannelLag, EncoderEccentricity, SensorGain, SensorOffset)


def by_channel(effects: Iterable[Effect]) -> dict[str, list[SensorEffect]]:
    """The sensor effects among these that are not neutral, by the channel on which they act."""
    found: dict[str, list[SensorEffect]] = {}
    for effect in effects:
        if isinstance(effect, SensorEffect) and not effect.is_neutral:
            found.setdefault(effect.channel, []).append(effect)
    return found


def measure(effects: Iterable[SensorEffect], x: ArrayLike, t: ArrayLike) -> Array:
    """A channel as the sensor with all of these effects reports it.

    They act in the order lag, eccentricity, gain, offset, users' own. Several of one kind have the same input, and
    their errors add.

    Args:
        effects: on this channel; neutral ones change nothing, bit for bit.
        x: the true channel (samples,).
        t: times of the samples [s].

    Example:
        >>> errors = [fd.effects.SensorGain("q.elbow", gain=0.5), fd.effects.SensorOffset("q.elbow", offset=0.25)]
        >>> fd.effects.measure(errors, x=[0.0, 1.0], t=[0.0, 0.01])
        array([0.25, 1.75])
    """
    channel = np.asarray(x, dtype=float)
    acting = [effect for effect in effects if not effect.is_neutral]
    lags = [effect for effect in acting if isinstance(effect, ChannelLag)]
    if lags:
        lag = dataclasses.replace(lags[0], delay=sum(effect.delay for effect in lags))
        channel = lag.measured(channel, t)
    for kind in _ORDER[1:]:
        errors = [effect.error(channel) for effect in acting if isinstance(effect, kind)]
        channel = channel + sum(errors) if errors else channel
    for effect in acting:
        if not isinstance(effect, _ORDER):
            channel = np.asarray(effect.measured(channel, t), dtype=float)
    return channel


def lag(effects: Iterable[SensorEffect]) -> float:
    """The lag of a channel with these effects [s]."""
    return math.fsum(effect.lateness for effect in effects)


def instant(effects: Iterable[SensorEffect]) -> list[SensorEffect]:
    """Those of them that do not make the channel late: `measure` and `recovered` take them sample by sample."""
    return [effect for effect in effects if not effect.lateness]


def slope(effects: Iterable[SensorEffect], x: Array, t: ArrayLike) -> Array:
    """Derivative of the reported channel by the true one, by central differences [1].

    Args:
        effects: on the channel.
        x: true values.
        t: their times [s].
    """
    effects = list(effects)
    return (measure(effects, x + SLOPE_STEP, t) - measure(effects, x - SLOPE_STEP, t)) / (2.0 * SLOPE_STEP)


def recovered(effects: Iterable[SensorEffect], reported: ArrayLike, t: ArrayLike) -> Array:
    """The true channel behind a reported one, but for its lag, which is a shift in time: the inverse of `measure`.

    Users' own effects by Newton's method, sample by sample; then offset and gain; eccentricity by fixed-point
    iteration, each round of which reduces the error by the factor amplitude times harmonic, far below 1.

    Args:
        effects: on this channel; those that make it late are passed over.
        reported: the measured channel (samples,).
        t: times of the samples [s].

    Example:
        >>> errors = [fd.effects.SensorGain("q.elbow", gain=0.5), fd.effects.SensorOffset("q.elbow", offset=0.25)]
        >>> fd.effects.recovered(errors, reported=[0.25, 1.75], t=[0.0, 0.01])
        array([0., 1.])
    """
    acting = [effect for effect in instant(effects) if not effect.is_neutral]
    x = _newton([effect for effect in acting if not isinstance(effect, _ORDER)], np.asarray(reported, float), t)
    offset = sum(effect.offset for effect in acting if isinstance(effect, SensorOffset))
    gain = sum(effect.gain for effect in acting if isinstance(effect, SensorGain))
    x = (x - offset) / (1.0 + gain)
    discs = [effect for effect in acting if isinstance(effect, EncoderEccentricity)]
    seen = x
    for _ in range(DISC_ROUNDS if discs else 0):
        before, x = x, seen - sum(effect.error(x) for effect in discs)
        if np.abs(x - before).max(initial=0.0) < DISC_ROUNDING * np.spacing(np.abs(x).max(initial=0.0)):
            break
    return x


def _newton(effects: list[SensorEffect], reported: Array, t: ArrayLike) -> Array:
    """The channel that effects of any law make the reported one of."""
    x = reported
    for _ in range(NEWTON_ROUNDS if effects else 0):
        rise = slope(effects, x, t)
        step = (reported - measure(effects, x, t)) / np.where(np.abs(rise) > SMALLEST_SLOPE, rise, 1.0)
        x = x + step
        if not np.abs(step).max(initial=0.0) > NEWTON_ROUNDING * np.abs(x).max(initial=0.0):
            break
    return x
