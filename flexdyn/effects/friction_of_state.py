"""Friction that depends on position, on the motion so far, or on time."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from typing import Self

import numpy as np

from flexdyn.effects.extent import SLOW_HARMONICS, MotionExtent
from flexdyn.effects.joint_effect import JointEffect
from flexdyn.effects.memory import MemoryEffect
from flexdyn.effects.parameters import parameter, spaced
from flexdyn.effects.waves import WaveEffect

LONGEST_BRISTLE_TIME = 0.1
"""Longest time constant of bristles that is fitted, damping/stiffness [s]."""


class PositionDependentFriction(WaveEffect, JointEffect):
    """Dry friction that comes and goes over a turn: an eccentric bearing, teeth of uneven fit.

    ``f = amplitude (1 + sin(harmonic x + phase)) Sgn(u)``, set-valued at rest; it is never negative.

    Args:
        joint: its name.
        side: ``link`` or ``motor``.
        amplitude: mean level, and amplitude of its variation [N m].
        harmonic: cycles per reflected turn; once per motor turn is the gear ratio [1], of a prismatic joint [rad/m].
        phase: [rad].
    """

    sides = ("link", "motor")
    law = "amplitude*(1 + sin(harmonic*x + phase))*Sgn(u)"
    shown = {"amplitude": 0.5, "harmonic": 2.0, "phase": 0.0}
    linear_bounds = (-math.inf, -math.inf, -math.inf)
    small_size = 1.0
    with_direction = True
    plainer = ("coulomb_friction",)  # not contained: friction that varies by less than its mean is both laws

    amplitude: float = parameter("N m", lower=0.0)

    @classmethod
    def tried(cls, extent: MotionExtent) -> Iterable[Sequence[float]]:
        """See the base class."""
        return extent.waves(SLOW_HARMONICS) if extent.turns else extent.waves((), (1.0, 2.0))

    @classmethod
    def numbers_of(cls, point: Sequence[float], x: Sequence[float]) -> dict[str, float] | None:
        """From the weights of ``1 + sin``, ``1 + cos`` and ``1 - sin``."""
        return super().numbers_of(point, (x[0] - x[2], x[1]))


class PreslidingFriction(MemoryEffect):
    """Friction as of bristles that bend before they slip: a spring for small motions, a level for large ones.

    ``f = stiffness z + damping z'``, ``z' = u - stiffness abs(u) z/level``. It is not dry: under a torque below its
    level it creeps. It stores ``1/2 stiffness z^2`` and never supplies energy beyond that. Source: the LuGre model
    without Stribeck effect (Canudas de Wit, Olsson, Astrom, Lischinsky, IEEE TAC 40(3), 1995, eq. 1-3).

    Args:
        joint: its name.
        side: ``link`` or ``motor``.
        level: reached after a few ``level/stiffness`` of one direction [N m].
        stiffness: of the bristles [N m/rad].
        damping: of the bristles [N m s/rad].
    """

    sides = ("link", "motor")
    law = "stiffness*z + damping*z', z' = u - stiffness*abs(u)*z/level"
    neutral = {"level": 0.0}
    shown = {"level": 1.0, "stiffness": 500.0}
    linear_bounds = (0.0,)
    contains = ("coulomb_friction",)
    plainer = ("coulomb_friction",)

    level: float = parameter("N m", lower=0.0, by_factor=True)
    stiffness: float = parameter("N m/rad", lower=0.0, strict=True)
    damping: float = parameter("N m s/rad", lower=0.0, step_at_zero=0.001, default=0.0)

    @classmethod
    def tried(cls, extent: MotionExtent) -> Iterable[Sequence[float]]:
        """Bends of the bristles, level/stiffness."""
        return ((float(reach),) for reach in extent.span * np.geomspace(1e-5, 0.05, 10))

    @classmethod
    def numbers_of(cls, point: Sequence[float], x: Sequence[float]) -> dict[str, float] | None:
        """Linear in its level where the bend is given."""
        return {"level": x[0], "stiffness": x[0] / point[0]} if x[0] > 0.0 else None

    def largest(self, name: str) -> float:
        """Bristles that hardly bend do not tell their damping."""
        return LONGEST_BRISTLE_TIME * self.stiffness if name == "damping" else math.inf

    @property
    def reach(self) -> float:
        """Largest bend of the bristles, level/stiffness [rad or m]."""
        return self.level / self.stiffness


class WarmUpFriction(JointEffect):
    """Viscous friction of a cold gear that fades as the run goes on.

    ``f = coefficient exp(-t/time_constant) u``, t since the start of the run.

    Args:
        joint: its name.
        side: ``link`` or ``motor``.
        coefficient: at the start of the run [N m s/rad].
        time_constant: [s].
    """

    sides = ("link", "motor")
    law = "coefficient*exp(-t/time_constant)*u"
    timed = True
    shown = {"coefficient": 1.0, "time_constant": 300.0}
    linear = ("coefficient",)
    grids = {"time_constant": ("seconds", spaced(0.04, 1.5, 7))}
    contains = ("viscous_friction",)
    plainer = ("viscous_friction",)

    coefficient: float = parameter("N m s/rad", lower=0.0)
    time_constant: float = parameter("s", lower=0.0, strict=True)

    def later(self, begin: float) -> Self:
        """The gear has warmed up for that time."""
        return self.replace(coefficient=self.coefficient * math.exp(-begin / self.time_constant))
