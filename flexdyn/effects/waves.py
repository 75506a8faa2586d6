"""The base of effects that are waves over a position."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import ClassVar, Self

import numpy as np

from flexdyn.effects.base import Effect
from flexdyn.effects.parameters import parameter

POSITION_STEP = 1e-6
"""Amplitude of a wave in a position at which a diagnosis computes what it does [rad or m]."""

WAVE_NUMBER = "rad/m"
"""Unit of a harmonic on a prismatic joint: that of its gear ratio, which is one cycle per turn of the motor."""


class WaveEffect(Effect, abstract=True):
    """``amplitude sin(harmonic position + phase)``, linear in its sine and cosine parts where the harmonic is given.

    The position of a prismatic joint is in m, so that its harmonic is the number of cycles in 2 pi m.

    Attributes:
        with_direction: whether the wave changes its sign with the velocity.
    """

    neutral = {"amplitude": 0.0}
    cycles = "harmonic"
    linear_bounds: ClassVar[tuple[float, ...]] = (-math.inf, -math.inf)
    axes = ("harmonic",)
    small_size: ClassVar[float] = POSITION_STEP
    with_direction: ClassVar[bool] = False

    amplitude: float = parameter("rad")
    harmonic: float = parameter("1", prismatic_unit=WAVE_NUMBER, chosen=True)
    phase: float = parameter("rad", around=True, step=0.01)

    def in_usual_range(self) -> Self:
        """The amplitude is positive, and the phase between -pi and pi."""
        turned = self.phase + (math.pi if self.amplitude < 0.0 else 0.0)
        if self.amplitude >= 0.0 and abs(turned) <= math.pi:
            return self
        return self.replace(amplitude=abs(self.amplitude), phase=math.remainder(turned, 2.0 * math.pi))

    @classmethod
    def numbers_of(cls, point: Sequence[float], x: Sequence[float]) -> dict[str, float] | None:
        """From its sine and cosine parts."""
        return {"amplitude": float(np.hypot(x[0], x[1])), "harmonic": point[0], "phase": math.atan2(x[1], x[0])}
