"""Effects between the motors of two joints: drag and dry friction of parts that both of them move."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from typing import Any

import numpy as np

from flexdyn.arrays import Array
from flexdyn.effects.base import Effect
from flexdyn.effects.joint_effect import JointEffect
from flexdyn.effects.parameters import parameter
from flexdyn.errors import InputError


class CouplingEffect(JointEffect, abstract=True):
    """An effect between the motors of two joints; its torque is of the velocity of the second one's rotor.

    Example:
        >>> drag = fd.effects.JointCoupling("wrist_roll", other="wrist_pitch", coefficient=0.5)
        >>> drag.partner, drag.rubbing_ratio
        ('wrist_pitch', None)
    """

    sides = ("motor",)

    @property
    def partner(self) -> str:
        """Name of the second joint."""
        raise NotImplementedError

    @property
    def rubbing_ratio(self) -> float | None:
        """Velocity of the first rotor over that of the second one at which parts that rub between both do not slide.

        None: no parts rub between them.
        """
        return None

    def on_rotors(self, omega: Array, omega_other: Array) -> tuple[Array, Array]:
        """Torques on both rotors, on the right side of their equations (samples,) [N m].

        Args:
            omega: of the first rotor (samples,) [rad/s].
            omega_other: of the second one (samples,) [rad/s].
        """
        return -self.torque(0.0, omega_other), np.zeros_like(omega)


class CouplingPart(CouplingEffect, abstract=True):
    """One law of a `JointCoupling`, as the plant has it."""

    other: str = dataclasses.field(kw_only=True)

    @property
    def partner(self) -> str:
        """See the base class."""
        return self.other


class CouplingDrag(CouplingPart, abstract=True):
    """The drag of a `JointCoupling`, as the plant has it.

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
    """The dry friction of a `JointCoupling`, as the plant has it.

    Args:
        joint: its name.
        other: the joint to whose rotor it is coupled by friction.
        level: [N m].
        ratio: [1].
    """

    name = "dry_coupling"
    part_of = "joint_coupling"
    law = "level*Sgn(omega - ratio*omega of joint other)"
    neutral = {"level": 0.0}

    level: float = parameter("N m", lower=0.0)
    ratio: float = parameter("1")


class JointCoupling(CouplingEffect):
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

    law = "coefficient*omega of joint other + level*Sgn(omega - ratio*omega of joint other)"
    neutral = {"coefficient": 0.0, "level": 0.0}
    shown = {"coefficient": 0.5}
    linear = ("coefficient",)
    unproposed = ("level", "ratio")  # dry friction between motors is no candidate
    exact = ("ratio",)  # of teeth and pulleys
    prevalence = "often"

    coefficient: float = parameter("N m s/rad", default=0.0)
    level: float = parameter("N m", lower=0.0, by_factor=True, default=0.0)
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

    @property
    def partner(self) -> str:
        """See the base class."""
        return self.other

    @property
    def rubbing_ratio(self) -> float | None:
        """See the base class."""
        return self.ratio if self.level > 0.0 else None

    def on_rotors(self, omega: Array, omega_other: Array) -> tuple[Array, Array]:
        """See the base class."""
        drag, dry = self._drag_and_friction()
        rubbing = dry.torque(0.0, omega - self.ratio * omega_other)
        return -rubbing - drag.torque(0.0, omega_other), self.ratio * rubbing

    def check_beside(self, others: Sequence[Effect]) -> None:
        """Dry coupling is to one other motor only: torques in a chain of motors that stick are not determined.

        Raises:
            InputError: another dry coupling at one of its motors.
        """
        for first in others if self.level > 0.0 else ():
            if not isinstance(first, CouplingEffect) or first.rubbing_ratio is None:
                continue
            shared = {first.joint, first.partner} & {self.joint, self.partner}
            alike = (first.joint, first.partner, first.rubbing_ratio) == (self.joint, self.partner, self.rubbing_ratio)
            if shared and not alike:
                problem = f"{shared.pop()} has a dry coupling already"
                remedy = "a joint may have one with dry friction, or several with the same joint, other and ratio"
                raise InputError(problem, key="level", value=self.level, remedy=remedy)

    @classmethod
    def _example_place(cls, joint: str, other: str) -> dict[str, Any]:
        return super()._example_place(joint, other) | {"other": other}

    def _evaluate(self, t: Array, x: Array, u: Array, tau: Array, z: Array | None = None) -> Array:
        return -self.on_rotors(np.zeros_like(u), u)[0]  # u is the other's velocity, with this one at rest

    def _drag_and_friction(self) -> tuple[CouplingDrag, CouplingFriction]:
        drag = CouplingDrag(self.joint, side=self.side, other=self.other, coefficient=self.coefficient)
        dry = CouplingFriction(self.joint, side=self.side, other=self.other, level=self.level, ratio=self.ratio)
        return drag, dry
