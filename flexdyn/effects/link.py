"""Effects on the links themselves, and the coupling of one joint's drive to another's."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence

import numpy as np

from flexdyn.effects.base import Effect
from flexdyn.effects.extent import MotionExtent
from flexdyn.effects.joint_effect import JointEffect
from flexdyn.effects.parameters import parameter
from flexdyn.errors import InputError


class InertiaEffect(Effect, abstract=True):
    """A mass that moves with a link: it changes M(q) and h(q, v).

    Example:
        >>> fd.effects.Payload(mass=0.2, frame="link_2").point_mass
        ('link_2', 0.2)
    """

    stage = "inertia"
    no_torque = "it changes M(q) and h(q, v)"

    @property
    def point_mass(self) -> tuple[str | None, float]:
        """Frame at whose origin the mass is, None for the last one of the chain, and the mass [kg]."""
        raise NotImplementedError


class Payload(InertiaEffect):
    """A point mass that the arm carries.

    It enters M(q) and h(q, v) like any mass: ``M += mass J^T J`` with the frame's translational Jacobian J, and its
    weight loads the joints. Paper: m_e, the mass of the end effector, and m_L in eq. 16-19.

    Args:
        mass: [kg].
        frame: the mass is at the origin of this frame; default: the last frame of the chain.
    """

    law = "a point mass at the origin of frame"
    shown = {"mass": 1.0}

    linear = ("mass",)
    small_size = 1e-3

    mass: float = parameter("kg", lower=0.0)
    frame: str | None = None

    @property
    def point_mass(self) -> tuple[str | None, float]:
        """See the base class."""
        return self.frame, self.mass


class LinkEffect(JointEffect, abstract=True):
    """A torque on a joint's link, on the right side of its equation."""

    sides = ("link",)


class ParallelSpring(LinkEffect):
    """A spring between a link and the one before it: a balancing spring, a stiff cable.

    ``tau_link = -stiffness (q - rest)``, on the right side of the link's equation.

    Args:
        joint: its name.
        stiffness: [N m/rad].
        rest: position at which its torque is zero [rad].
    """

    law = "-stiffness*(q - rest)"
    shown = {"stiffness": 20.0, "rest": 0.3}

    linear = ("stiffness",)
    axes = ("rest",)

    stiffness: float = parameter("N m/rad", lower=0.0, by_factor=True)
    rest: float = parameter("rad", step=0.001)

    @classmethod
    def tried(cls, extent: MotionExtent) -> Iterable[Sequence[float]]:
        """See the base class."""
        rests = np.linspace(extent.low - extent.span, extent.high + extent.span, 13)
        return ((float(rest),) for rest in rests)


class PositionTorque(LinkEffect):
    """A torque that depends on the joint's position alone: a counterbalance, cables, a hose.

    ``tau_link = -(cos_1 cos q + sin_1 sin q + cos_2 cos 2q + sin_2 sin 2q)``, on the right side of the link's
    equation. For a prismatic joint q is in m.

    Args:
        joint: its name.
        cos_1: [N m].
        sin_1: [N m].
        cos_2: [N m].
        sin_2: [N m].
    """

    law = "-(cos_1*cos(q) + sin_1*sin(q) + cos_2*cos(2*q) + sin_2*sin(2*q))"
    shown = {"cos_1": 1.0, "sin_1": 0.0, "cos_2": 0.0, "sin_2": 0.3}

    linear = ("cos_1", "sin_1", "cos_2", "sin_2")

    cos_1: float = parameter("N m")
    sin_1: float = parameter("N m")
    cos_2: float = parameter("N m")
    sin_2: float = parameter("N m")

    @classmethod
    def tried(cls, extent: MotionExtent) -> Iterable[Sequence[float]]:
        """None of a sliding joint."""
        return super().tried(extent) if extent.turns else ()


class EndStop(LinkEffect):
    """Bumpers at the ends of a joint's range: they press, they never pull.

    ``tau_link = -(stiffness (q - upper) + damping v)`` beyond upper, likewise below lower, and 0 if that would pull
    the link into the bumper.

    Args:
        joint: its name.
        lower: [rad]; -inf: no bumper on this side.
        upper: [rad]; inf: no bumper on this side.
        stiffness: [N m/rad].
        damping: [N m s/rad].
    """

    law = "q > upper: -(stiffness*(q - upper) + damping*v), if that presses; likewise q < lower"
    neutral = {"stiffness": 0.0, "damping": 0.0}
    shown = {"lower": -1.0, "upper": 1.0, "stiffness": 100.0, "damping": 2.0}

    keeps_to = "range"
    linear_bounds = (0.0,)

    lower: float = parameter("rad", infinite=True, step=0.001)
    upper: float = parameter("rad", infinite=True, step=0.001)
    stiffness: float = parameter("N m/rad", lower=0.0, by_factor=True)
    damping: float = parameter("N m s/rad", lower=0.0, step_at_zero=0.001)

    def __post_init__(self) -> None:
        """Check the numbers, and that the stops leave room."""
        super().__post_init__()
        if self.lower > self.upper or self.lower == math.inf or self.upper == -math.inf:
            remedy = f"it must be at most upper, {self.upper:g}"
            raise InputError("the stops leave no room", key=f"{self.name}.lower", value=self.lower, remedy=remedy)

    @classmethod
    def tried(cls, extent: MotionExtent) -> Iterable[Sequence[float]]:
        """A limit within the range of the motion, and on which side the bumper is: -1 below, 1 above."""
        depths = (extent.span * np.geomspace(0.003, 0.15, 7)).tolist()
        return (*((extent.low + d, -1.0) for d in depths), *((extent.high - d, 1.0) for d in depths))

    @classmethod
    def numbers_of(cls, point: Sequence[float], x: Sequence[float]) -> dict[str, float] | None:
        """Linear in its stiffness; one bumper without damping."""
        lower, upper = (point[0], math.inf) if point[1] < 0 else (-math.inf, point[0])
        return {"lower": lower, "upper": upper, "stiffness": x[0], "damping": 0.0} if x[0] > 0.0 else None
