"""Effects on the measurement and not on the motion: they change the recording of a run, not its states."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterable, Sequence
from typing import Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike

from flexdyn.arrays import Array
from flexdyn.effects.base import Effect, Side, Stage
from flexdyn.effects.extent import DELAYS, MotionExtent
from flexdyn.effects.parameters import parameter
from flexdyn.effects.waves import WAVE_NUMBER, WaveEffect
from flexdyn.errors import InputError
from flexdyn.records.units import HELD

POSITIONS = ("q", "theta")
"""Signals of the encoders."""
SAME_INSTANT = 1e-10
"""Times closer than this are one [s]."""


class SensorEffect(Effect, abstract=True):
    """An effect on one measured channel.

    Class attributes:
        signals: signals that it can act on; empty means any.

    Example:
        >>> fd.effects.SensorOffset("q.elbow", offset=0.25).measured(x=[0.0, 1.0], t=[0.0, 0.01])
        array([0.25, 1.25])
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
    grids = {"delay": ("one", DELAYS)}
    prevalence = "often"
    late_by = "delay"

    delay: float = parameter("s", lower=0.0)

    def measured(self, x: ArrayLike, t: ArrayLike) -> Array:
        """What the sensor reports: see the base class."""
        true, times = np.asarray(x, dtype=float), np.asarray(t, dtype=float)
        if self.signal not in HELD:
            return np.asarray(np.interp(times - self.delay, times, true))
        # Rounding of t - delay must not miss a sample by its last bit.
        return true[np.maximum(np.searchsorted(times, times - self.delay + SAME_INSTANT, side="right") - 1, 0)]


class EncoderEccentricity(WaveEffect, SensorEffect):
    """An eccentric encoder disc: an error that is periodic over a turn.

    ``measured = x + amplitude sin(harmonic x + phase)``.

    Args:
        channel: ``q.<joint>`` or ``theta.<joint>``.
        amplitude: [rad].
        harmonic: cycles per reflected turn [1], of a prismatic joint [rad/m].
        phase: [rad].
    """

    law = "x + amplitude*sin(harmonic*x + phase)"
    shown = {"amplitude": 0.002, "harmonic": 1.0, "phase": 0.0}
    position_error = "amplitude"
    natural_size = 0.01
    signals = POSITIONS

    harmonic: float = parameter("1", prismatic_unit=WAVE_NUMBER, default=1.0, chosen=True)

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
    shown = {"offset": 0.01}
    natural_size = 0.01
    linear = ("offset",)
    is_constant = True
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
    shown = {"gain": 0.05}
    natural_size = 0.03
    linear = ("gain",)
    small_size = 1e-4

    gain: float = parameter("1")

    def error(self, x: Array) -> Array:
        """Proportional to the value."""
        return self.gain * x
