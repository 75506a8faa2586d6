"""Effects between the motors of two joints: drag and dry friction of parts that both of them move."""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np

from flexdyn.arrays import Array
from flexdyn.effects.base import Effect
from flexdyn.effects.joint_effect import JointEffect
from flexdyn.effects.parameters import parameter
from flexdyn.errors import InputError


class CouplingPart(JointEffect, abstract=True):
    """One law of a `JointCoupling`, as the plant has it."""

    sides = ("motor",)

    other: str = dataclasses.field(kw_only=True)


class CouplingDrag(CouplingPart, abstract=True):
    """The drag.

    Args:
        joint: its name.
        other: the joint whose rotor turns.
        coefficient: [N m s/rad].
    """

    name = "joint_coupling"
    law = "coefficient*omega of joint other"
    neutral = {"coefficient": 0.0}

    coefficient: float = parameter("N m s/rad")


class CouplingFriction(CouplingPart, abstract=True):
    """The dry friction.

    Args:
        joint: its name.
        other: the joint to whose rotor it is coupled by friction.
        level: [N m].
        ratio: [1].
    """

    name = "dry_coupling"
    law = "level*Sgn(omega - ratio*omega of joint other)"
    neutral = {"level": 0.0}

    level: float = parameter("N m", lower=0.0)
    ratio: float = parameter("1")


class JointCoupling(JointEffect):
    """The rotor of one joint drags on that of another: differential wrists, belts over a common shaft.

    ``f_motor = coefficient omega`` of joint `other`, on the left side of the rotor's equation of `joint`. This part is
    not friction: it may supply power. With a `level` the parts between both motors have dry friction of their
    relative velocity ``u = omega - ratio omega_other``: ``level Sgn(u)`` on the rotor of `joint` and ``-ratio`` times
    that on the rotor of `other`. It is set-valued: what it holds moves as one, u = 0 to the last bit.

    Args:
        joint: its name.
        other: the joint whose rotor turns.
        coefficient: [N m s/rad]; of either sign.
        level: of dry friction between both [N m].
        ratio: velocity of the rotor of `joint` over that of `other` without dry friction [1]; of either sign.
    """

    sides = ("motor",)
    law = "coefficient*omega of joint other + level*Sgn(omega - ratio*omega of joint other)"
    neutral = {"coefficient": 0.0, "level": 0.0}
    shown = {"coefficient": 0.5}
    linear = ("coefficient",)
    unproposed = ("level", "ratio")  # dry friction between motors is no candidate
    prevalence = "often"

    coefficient: float = parameter("N m s/rad", default=0.0)
    level: float = parameter("N m", lower=0.0, default=0.0)
    ratio: float = parameter("1", default=1.0)
    other: str = dataclasses.field(kw_only=True)

    def __post_init__(self) -> None:
        """Check the numbers, and that there are two joints."""
        super().__post_init__()
        if not isinstance(self.other, str) or not self.other:
            raise InputError("a joint's name is needed", key=f"{self.name}.other", value=self.other)
        if self.other == self.joint:
            remedy = "name another joint, or use viscous_friction"
            raise InputError(
                "a joint does not couple to itself", key=f"{self.name}.other", value=self.other, remedy=remedy
            )
        if self.ratio == 0.0:
            remedy = "at 0 the other motor does not take part: use coulomb_friction"
            raise InputError("a ratio other than 0 is needed", key=f"{self.name}.ratio", value=0.0, remedy=remedy)

    def parts(self) -> tuple[Effect, ...]:
        """Its laws in the plant: the drag, the dry friction, or both."""
        return tuple(part for part in self._drag_and_friction() if not part.is_neutral)

    def torques(self, omega: Array, omega_other: Array) -> tuple[Array, Array]:
        """Its torques on the rotors of `joint` and of `other`, on the left side of their equations [N m].

        Args:
            omega: velocity of the rotor of `joint` [rad/s].
            omega_other: the same of `other`.
        """
        drag, dry = self._drag_and_friction()
        rubbing = dry.torque(0.0, omega - self.ratio * omega_other)
        return drag.torque(0.0, omega_other) + rubbing, -self.ratio * rubbing

    def matches(self, second: JointCoupling) -> bool:
        """Whether the dry friction of both is of one relative velocity, so that the levels add up."""
        return (self.joint, self.other, self.ratio) == (second.joint, second.other, second.ratio)

    @classmethod
    def _example_place(cls, joint: str, other: str) -> dict[str, Any]:
        return super()._example_place(joint, other) | {"other": other}

    def _evaluate(self, t: Array, x: Array, u: Array, tau: Array, z: Array | None = None) -> Array:
        return self.torques(np.zeros_like(u), u)[0]  # u is the other's velocity, with this one at rest

    def _drag_and_friction(self) -> tuple[CouplingDrag, CouplingFriction]:
        drag = CouplingDrag(self.joint, side=self.side, other=self.other, coefficient=self.coefficient)
        dry = CouplingFriction(self.joint, side=self.side, other=self.other, level=self.level, ratio=self.ratio)
        return drag, dry
