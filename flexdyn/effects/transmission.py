"""Effects between rotor and link: they act on the deflection delta = theta - q and its rate.

Kinematic errors come first, then the dead zone, then every spring law. The damping terms take the true velocities.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from typing import ClassVar

import numpy as np
from numpy.typing import ArrayLike

from flexdyn import _core
from flexdyn.arrays import Array
from flexdyn.effects.extent import MotionExtent
from flexdyn.effects.joint_effect import JointEffect
from flexdyn.effects.memory import MemoryEffect
from flexdyn.effects.parameters import parameter, spaced
from flexdyn.effects.waves import WaveEffect


class TransmissionEffect(JointEffect, abstract=True):
    """An effect between rotor and link."""

    sides = ("transmission",)


class JointElasticity(TransmissionEffect):
    """The elasticity of a joint that was taken for rigid.

    The joint becomes elastic: rotor and link have positions of their own, and ``tau_s = stiffness delta`` (paper,
    eq. 3, 4), plus the joint's `damping`. Several on one joint add their stiffness.

    Args:
        joint: its name; it must be rigid without this effect, and its rotor must have inertia.
        stiffness: [N m/rad]; infinite: it stays rigid.
    """

    stage = "spring"
    law = "a rigid joint becomes elastic: stiffness*delta"
    neutral = {"stiffness": math.inf}
    shown = {"stiffness": 5000.0}
    linear_bounds = (0.0,)
    prevalence = "often"
    makes_elastic = "stiffness"

    stiffness: float = parameter("N m/rad", lower=0.0, strict=True)

    @classmethod
    def numbers_of(cls, point: Sequence[float], x: Sequence[float]) -> dict[str, float] | None:
        """Linear in its compliance."""
        return {"stiffness": 1.0 / x[0]} if x[0] > 0.0 else None

    def _evaluate(self, t: Array, x: Array, u: Array, tau: Array, z: Array | None = None) -> Array:
        # The core has no law of this name: the model adds it to the joint's stiffness.
        return self.stiffness * x


class TransmissionDamping(TransmissionEffect):
    """Damping across the spring of an elastic joint.

    ``tau_s += coefficient (omega - v)``, with the true velocities. It adds to the joint's `damping`.

    Args:
        joint: its name; it must be elastic.
        coefficient: [N m s/rad].
    """

    law = "coefficient*(omega - v)"
    shown = {"coefficient": 2.0}
    damps_spring = "coefficient"
    linear = ("coefficient",)
    of_velocity = True

    coefficient: float = parameter("N m s/rad", lower=0.0)


class HardeningSpring(TransmissionEffect):
    """A transmission whose stiffness grows with the deflection, as in harmonic drives.

    ``tau_s += cubic delta^3``, in addition to the joint's own ``K delta``; it stores ``1/4 cubic delta^4``.

    Args:
        joint: its name; it must be elastic.
        cubic: [N m/rad^3].
    """

    bends_spring = True
    law = "cubic*delta^3"
    shown = {"cubic": 2.0e8}
    linear = ("cubic",)

    cubic: float = parameter("N m/rad^3", lower=0.0)


class DeflectionEffect(TransmissionEffect, abstract=True):
    """An effect that changes the deflection before every spring law sees it.

    Class attributes:
        of_rotor: what it adds depends on the rotor's position alone, and the true deflection goes in.

    Example:
        >>> fd.effects.Backlash("elbow", half_gap=0.25).deflection([-1.0, 0.0, 1.0])  # beyond the gap on either side
        array([-0.75,  0.  ,  0.75])
    """

    no_torque = "use deflection(delta, theta)"
    of_rotor: ClassVar[bool] = False

    def deflection(self, delta: ArrayLike, theta: ArrayLike = 0.0) -> Array:
        """The deflection after the law [rad or m].

        Args:
            delta: before it, theta - q at first [rad or m].
            theta: rotor position [rad or m].
        """
        columns = np.broadcast_arrays(np.asarray(delta, dtype=float), np.asarray(theta, dtype=float))
        delta_, theta_ = (np.array(column, order="C") for column in columns)
        nothing = np.zeros(delta_.shape)
        return self._evaluate(nothing, delta_, nothing, theta_)

    def slope(self, theta: Array) -> Array:
        """Derivative of what it adds by the rotor's position [1]: the rotor's torque is larger by this share."""
        at = np.ascontiguousarray(theta, dtype=float)
        out = np.empty(at.shape)
        _core.deflection_slope(self.name, self.values, at, out)
        return out

    @property
    def gap(self) -> float:
        """Deflection, from the middle of a dead zone, up to which the springs see none [rad or m]."""
        return 0.0


class Backlash(DeflectionEffect):
    """A gap between rotor and link: within the gap the transmission carries no spring torque.

    ``delta -> delta - half_gap`` above the gap, ``delta + half_gap`` below it, 0 inside. Several on one joint add
    their half gaps.

    Args:
        joint: its name; it must be elastic.
        half_gap: half of the gap [rad].
    """

    law = "delta -> dead zone of +-half_gap"
    neutral = {"half_gap": 0.0}
    shown = {"half_gap": 0.01}
    axes = ("half_gap",)
    bends_spring = True

    half_gap: float = parameter("rad", lower=0.0, by_factor=True)

    @classmethod
    def tried(cls, extent: MotionExtent) -> Iterable[Sequence[float]]:
        """See the base class."""
        return ((gap,) for gap in extent.half_gaps)

    @property
    def gap(self) -> float:
        """See the base class."""
        return self.half_gap


class SpringHysteresis(MemoryEffect):
    """A transmission that returns less energy than it was given: rubbing teeth, a flexspline's material.

    ``tau_s += stiffness h``, ``h' = delta' - abs(delta') h/width``, delta after kinematic error and dead zone. It
    stores ``1/2 stiffness h^2`` and never supplies energy beyond that. Source: the model of Bouc (1967) and Wen (J.
    Eng. Mech. Div. ASCE 102, 1976) with exponent 1 and no softening on unloading.

    Args:
        joint: its name; it must be elastic.
        stiffness: at a reversal, in addition to the joint's K [N m/rad]; far from it the torque is stiffness*width.
        width: scale of the deflection over which the torque changes its sign after a reversal [rad].
    """

    sides = ("transmission",)
    bends_spring = True
    law = "stiffness*h, h' = delta' - abs(delta')*h/width"
    shown = {"stiffness": 1000.0, "width": 0.002}
    linear = ("stiffness",)
    grids = {"width": ("deflection", spaced(0.003, 3.0, 9))}

    stiffness: float = parameter("N m/rad", lower=0.0, by_factor=True)
    width: float = parameter("rad", lower=0.0, strict=True)

    @property
    def reach(self) -> float:
        """Largest abs(h): the width [rad or m]."""
        return self.width


class KinematicError(WaveEffect, DeflectionEffect):
    """A gear with an uneven ratio over a turn: it deflects the spring as the rotor turns.

    ``delta -> delta + amplitude sin(harmonic theta + phase)``. The torque on the rotor is the spring's torque times ``1
    + amplitude harmonic cos(harmonic theta + phase)``, so that energy is conserved. Source: the position error of
    harmonic drives (Tuttle and Seering, IEEE Trans. Robotics Automation 12(3), 1996); the conservative form, Gandhi and
    Ghorbel (Robotica 20, 2002).

    Args:
        joint: its name; it must be elastic.
        amplitude: at the link [rad].
        harmonic: cycles per reflected turn; once per motor turn is the gear ratio [1], of a prismatic joint [rad/m].
        phase: [rad].
    """

    law = "delta -> delta + amplitude*sin(harmonic*theta + phase)"
    shown = {"amplitude": 0.002, "harmonic": 2.0, "phase": 0.0}
    natural_size = 0.01
    order = 0
    position_error = "amplitude"
    of_rotor = True

    @classmethod
    def tried(cls, extent: MotionExtent) -> Iterable[Sequence[float]]:
        """See the base class."""
        return extent.waves((1.0, 2.0, 3.0, 4.0), (1.0, 2.0, 4.0))
