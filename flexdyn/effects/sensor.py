"""Effects on the measurement and not on the motion: they change the recording of a run, not its states."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterable, Sequence
from typing import Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike

from flexdyn.checks import Array
from flexdyn.effects.base import Effect, Side, Stage, parameter
from flexdyn.effects.extent import MotionExtent
from flexdyn.effects.waves import WaveEffect
from flexdyn.errors import InputError

POSITIONS = ("q", "theta")
HELD = ("tau", "tau_applied", "voltage", "duty", "goal")
"""Signals that keep their value from one sample to the next."""
SAME_INSTANT = 1e-10
"""Times closer than this are one [s]."""
DISC_ROUNDS, DISC_ROUNDING = 20, 4.0
"""Rounds for the angle under an eccentric disc, at most, and the change that is rounding [units of the last place]."""
NEWTON_ROUNDS, NEWTON_ROUNDING = 30, 1e-14
"""Steps of Newton's method, at most, and the share of the largest value below which a step is rounding."""
NEWTON_DIFFERENCE, SMALLEST_SLOPE = 1e-6, 0.05
"""Step of the differences by which its slopes are taken, and the slope below which 1 is taken instead."""


class SensorEffect(Effect, abstract=True):
    """An effect on one measured channel.

    Class attributes:
        signals: signals that it can act on; empty means any.
    """

    sides: ClassVar[tuple[Side, ...]] = ("sensor",)
    stage: ClassVar[Stage] = "sensor"
    no_torque = "use measured(x, t)"
    signals: ClassVar[tuple[str, ...]] = ()

    channel: str = dataclasses.field(kw_only=False)
    side: Side = "sensor"

    def __post_init__(self) -> None:
        """Check the numbers, and that the channel has the form ``<signal>.<joint>``."""
        super().__post_init__()
        key = f"{self.name}.channel"
        signal, dot, joint = self.channel.partition(".") if isinstance(self.channel, str) else ("", "", "")
        if not (signal and dot and joint):
            raise InputError("a channel is needed", key=key, value=self.channel, remedy="write <signal>.<joint>")
        if self.signals and signal not in self.signals:
            remedy = f"the signal is {' or '.join(self.signals)}"
            raise InputError("the effect does not act on this signal", key=key, value=self.channel, remedy=remedy)
        if self.side != "sensor":
            raise InputError("no such side for this effect", key=f"{self.name}.side", value=self.side, remedy="sensor")

    @property
    def signal(self) -> str:
        """What is measured: ``q``, ``theta``, ``tau_s``, ..."""
        return self.channel.partition(".")[0]

    @property
    def joint(self) -> str:
        """Name of the joint that is measured."""
        return self.channel.partition(".")[2]

    def measured(self, x: ArrayLike, t: ArrayLike) -> Array:
        """What the sensor reports.

        Args:
            x: the true channel (samples,), in its unit.
            t: times of the samples, increasing (samples,) [s].

        Returns:
            the measured channel (samples,).
        """
        true = np.asarray(x, dtype=float)
        return true + self.error(true)

    def error(self, x: Array) -> Array:
        """The error that is added to the true channel, if it depends on the value alone."""
        raise NotImplementedError

    @classmethod
    def _example_place(cls, joint: str, other: str) -> dict[str, Any]:
        return {"channel": f"q.{joint}"}


class ChannelLag(SensorEffect):
    """A measured channel is late: filters, buses, different clocks.

    ``measured(t) = x(t - delay)``, linear between samples (commanded torques are held). Before the first sample
    arrives, it is the first value. Several on one channel add.

    Args:
        channel: ``<signal>.<joint>``.
        delay: [s].
    """

    law = "x(t - delay)"
    neutral = {"delay": 0.0}
    shown = {"delay": 0.005}
    prevalence = "often"
    late_by = "delay"

    delay: float = parameter("s", lower=0.0)

    def measured(self, x: ArrayLike, t: ArrayLike) -> Array:
        """What the sensor reports: see the base class."""
        true, times = np.asarray(x, dtype=float), np.asarray(t, dtype=float)
        if self.signal not in HELD:
            return np.asarray(np.interp(times - self.delay, times, true))
        # Rounding of t - delay must not miss a sample by its last bit.
        instants = times - self.delay + SAME_INSTANT
        return true[np.maximum(np.searchsorted(times, instants, side="right") - 1, 0)]


class EncoderEccentricity(WaveEffect, SensorEffect):
    """An eccentric encoder disc: an error that is periodic over a turn.

    ``measured = x + amplitude sin(harmonic x + phase)``.

    Args:
        channel: ``q.<joint>`` or ``theta.<joint>``.
        amplitude: [rad].
        harmonic: cycles per reflected turn [1].
        phase: [rad].
    """

    law = "x + amplitude*sin(harmonic*x + phase)"
    shown = {"amplitude": 0.002, "harmonic": 1.0, "phase": 0.0}
    position_error = "amplitude"
    natural_size = 0.01
    signals = POSITIONS

    harmonic: float = parameter("1", default=1.0)

    @classmethod
    def tried(cls, extent: MotionExtent) -> Iterable[Sequence[float]]:
        """See the base class."""
        return extent.waves((1.0, 2.0), (1.0, 2.0) if extent.signal == "theta" else ())

    def error(self, x: Array) -> Array:
        """Over the true position [rad]."""
        return self.amplitude * np.sin(self.harmonic * x + self.phase)


class SensorOffset(SensorEffect):
    """A sensor with a wrong zero.

    ``measured = x + offset``.

    Args:
        channel: ``<signal>.<joint>``.
        offset: in the unit of the channel.
    """

    law = "x + offset"
    neutral = {"offset": 0.0}
    shown = {"offset": 0.01}
    natural_size = 0.01
    linear = ("offset",)
    position_error = "offset"

    offset: float = parameter("unit of the channel")

    @classmethod
    def small(cls, extent: MotionExtent) -> float:
        """See the base class."""
        return 1e-4 if extent.signal == "tau_s" else 1e-5

    def error(self, x: Array) -> Array:
        """A constant."""
        return np.full_like(x, self.offset)


class SensorGain(SensorEffect):
    """A sensor with a wrong scale.

    ``measured = (1 + gain) x``. Several on one channel add their gains.

    Args:
        channel: ``<signal>.<joint>``.
        gain: 0.05 means that it reports five percent too much; -2 that it is mounted the wrong way round [1].
    """

    law = "(1 + gain)*x"
    neutral = {"gain": 0.0}
    shown = {"gain": 0.05}
    natural_size = 0.03
    linear = ("gain",)
    small_size = 1e-4

    gain: float = parameter("1")

    def error(self, x: Array) -> Array:
        """Proportional to the value."""
        return self.gain * x


_ORDER = (ChannelLag, EncoderEccentricity, SensorGain, SensorOffset)


def measure(effects: Iterable[SensorEffect], x: ArrayLike, t: ArrayLike) -> Array:
    """A channel as the sensor with all of these effects reports it.

    They act in the order lag, eccentricity, gain, offset, users' own. Several of one kind have the same input, and
    their errors add.

    Args:
        effects: on this channel; neutral ones change nothing, bit for bit.
        x: the true channel (samples,).
        t: times of the samples [s].
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


def recovered(effects: Iterable[SensorEffect], reported: ArrayLike, t: ArrayLike) -> Array:
    """The true channel behind a reported one, but for its lag, which is a shift in time: the inverse of `measure`.

    Users' own effects by Newton's method, sample by sample; then offset and gain; eccentricity by fixed-point
    iteration, each round of which reduces the error by the factor amplitude times harmonic, far below 1.

    Args:
        effects: on this channel; those that make it late are passed over.
        reported: the measured channel (samples,).
        t: times of the samples [s].
    """
    acting = [effect for effect in effects if not effect.is_neutral and not isinstance(effect, ChannelLag)]
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
        low, now, high = (measure(effects, x + step, t) for step in (-NEWTON_DIFFERENCE, 0.0, NEWTON_DIFFERENCE))
        slope = (high - low) / (2.0 * NEWTON_DIFFERENCE)
        step = (reported - now) / np.where(np.abs(slope) > SMALLEST_SLOPE, slope, 1.0)
        x = x + step
        if not np.abs(step).max(initial=0.0) > NEWTON_ROUNDING * np.abs(x).max(initial=0.0):
            break
    return x
