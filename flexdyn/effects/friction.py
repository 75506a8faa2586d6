"""Friction: torques that oppose the velocity u of the link or of the rotor, on the left side of the equations."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from flexdyn.effects.base import JointEffect, parameter, spaced
from flexdyn.effects.memory import MemoryEffect


class ViscousFriction(JointEffect):
    """Friction proportional to speed.

    ``f = coefficient u``, u = v (link) or omega (motor). Paper, eq. 1, first term (b^v), and eq. 20, 21 (v_1, v_2).

    Args:
        joint: its name.
        side: ``link`` or ``motor``.
        coefficient: [N m s/rad].
    """

    sides = ("link", "motor")
    stage = "friction"
    law = "coefficient*u"
    neutral = {"coefficient": 0.0}
    shown = {"coefficient": 0.5}
    linear = ("coefficient",)
    prevalence = "everywhere"
    of_velocity = True

    coefficient: float = parameter("N m s/rad", lower=0.0)


class CoulombFriction(JointEffect):
    """Dry friction of one level, set-valued at rest.

    ``f = level Sgn(u)``, Sgn(0) = [-1, 1]. Paper, eq. 1, second term (b^d); its sgn(0) = 0 (eq. 2) would let a loaded
    joint start to slide from rest under any torque, so flexdyn uses the set-valued Sgn.

    Args:
        joint: its name.
        side: ``link`` or ``motor``.
        level: [N m].
    """

    sides = ("link", "motor")
    stage = "dry"
    law = "level*Sgn(u)"
    neutral = {"level": 0.0}
    shown = {"level": 1.0}
    linear = ("level",)
    prevalence = "everywhere"
    of_velocity = True

    level: float = parameter("N m", lower=0.0)


class AsymmetricFriction(JointEffect):
    """Dry friction with a level for each direction of motion, set-valued at rest.

    ``f = level_positive`` for u > 0, ``-level_negative`` for u < 0, any torque of ``[-level_negative,
    level_positive]`` at rest. Equal levels are Coulomb friction.

    Args:
        joint: its name.
        side: ``link`` or ``motor``.
        level_positive: against motion in the positive direction [N m].
        level_negative: against motion in the negative direction [N m].
    """

    sides = ("link", "motor")
    stage = "dry"
    law = "(level_positive if u > 0 else level_negative)*Sgn(u)"
    neutral = {"level_positive": 0.0, "level_negative": 0.0}
    shown = {"level_positive": 1.2, "level_negative": 0.7}
    linear = ("level_positive", "level_negative")
    contains = ("coulomb_friction", "torque_offset")
    plainer = ("coulomb_friction",)
    prevalence = "often"
    of_velocity = True

    level_positive: float = parameter("N m", lower=0.0)
    level_negative: float = parameter("N m", lower=0.0)


class StribeckFriction(JointEffect):
    """Dry friction in excess of the kinetic level that decreases with the speed.

    ``f = excess exp(-(|u|/velocity)^exponent) Sgn(u)``. Paper, eq. 1, third term: excess = b^s - b^d, velocity =
    epsilon, exponent 1. The break-away level is the sum of this excess and the Coulomb level.

    Args:
        joint: its name.
        side: ``link`` or ``motor``.
        excess: static minus kinetic level [N m].
        velocity: Stribeck velocity [rad/s].
        exponent: 1 in the paper, 2 in much of the literature [1].
    """

    sides = ("link", "motor")
    stage = "dry"
    law = "excess*exp(-(abs(u)/velocity)^exponent)*Sgn(u)"
    neutral = {"excess": 0.0}
    shown = {"excess": 0.5, "velocity": 0.1}
    linear = ("excess",)
    grids = {"velocity": ("speed", spaced(0.003, 0.4, 9))}
    prevalence = "often"
    of_velocity = True

    excess: float = parameter("N m", lower=0.0)
    velocity: float = parameter("rad/s", lower=0.0, strict=True)
    exponent: float = parameter("1", lower=0.0, strict=True, default=1.0)


class AsymmetricViscousFriction(JointEffect):
    """Viscous friction with a coefficient for each direction of motion.

    ``f = coefficient_positive u`` for u > 0, ``coefficient_negative u`` for u < 0: continuous, with a corner at rest.
    Equal coefficients are viscous friction. Source: the friction of a screw drive identified for either direction
    (Janot, Gautier, Brunot: Data set and reference models of EMPS, 2019).

    A coefficient may be negative if the same side also has viscous friction of at least that size: ``(-c, c)``
    describes the difference between the directions. Alone, a negative coefficient would supply energy.

    Args:
        joint: its name.
        side: ``link`` or ``motor``.
        coefficient_positive: for motion in the positive direction [N m s/rad].
        coefficient_negative: for motion in the negative direction [N m s/rad].
    """

    sides = ("link", "motor")
    stage = "friction"
    law = "(coefficient_positive if u > 0 else coefficient_negative)*u"
    neutral = {"coefficient_positive": 0.0, "coefficient_negative": 0.0}
    shown = {"coefficient_positive": 0.6, "coefficient_negative": 0.3}
    linear = ("coefficient_positive", "coefficient_negative")
    contains = ("viscous_friction",)
    plainer = ("viscous_friction",)
    of_velocity = True

    coefficient_positive: float = parameter("N m s/rad")
    coefficient_negative: float = parameter("N m s/rad")


class QuadraticDrag(JointEffect):
    """Drag that grows with the square of the speed: air, oil, grease.

    ``f = coefficient u abs(u)``.

    Args:
        joint: its name.
        side: ``link`` or ``motor``.
        coefficient: [N m s^2/rad^2].
    """

    sides = ("link", "motor")
    stage = "friction"
    law = "coefficient*u*abs(u)"
    neutral = {"coefficient": 0.0}
    shown = {"coefficient": 0.3}
    linear = ("coefficient",)
    of_velocity = True

    coefficient: float = parameter("N m s^2/rad^2", lower=0.0)


class LoadDependentFriction(JointEffect):
    """Dry friction in proportion to the torque that the gear carries, set-valued at rest.

    ``f = coefficient abs(tau_s) Sgn(omega)``, tau_s the transmission torque of this instant, damping included. Source:
    the load-dependent losses of worm, harmonic and planetary gears (1 - efficiency, to first order).

    Args:
        joint: its name; it must be elastic.
        coefficient: friction torque over transmission torque [1].
    """

    sides = ("motor",)
    stage = "dry"
    law = "coefficient*abs(tau_s)*Sgn(u)"
    neutral = {"coefficient": 0.0}
    shown = {"coefficient": 0.15}
    takes_load = True
    linear = ("coefficient",)
    natural_size = 0.15
    prevalence = "often"

    coefficient: float = parameter("1", lower=0.0)


class DirectionalGearLoss(JointEffect):
    """Dry friction in proportion to the load, one share where the motor drives and another where the load drives it.

    ``f = (driving if tau_s omega > 0 else driven) abs(tau_s) Sgn(omega)``, tau_s the transmission torque of this
    instant, damping included. Where ``tau_s omega > 0`` power flows from the motor to the link. Equal coefficients are
    `LoadDependentFriction`. The efficiency is ``1/(1 + driving)`` where the motor drives and ``1 - driven`` where the
    load does.

    At rest each direction has its own level, for one of them would be driving and the other one being driven::

        tau_s > 0:   f in [-driven tau_s, driving tau_s],
        tau_s < 0:   f in [-driving |tau_s|, driven |tau_s|].

    A rotor at rest has ``tau_m = tau_s + f``, so that it stays there while::

        (1 - driven) |tau_s| <= tau_m sign(tau_s) <= (1 + driving) |tau_s|.

    A gear with ``driven >= 1`` locks itself: without motor torque no load turns it back, and to let the load down the
    motor must push with more than ``(driven - 1) |tau_s|``. A rotor that the load has set in motion is then braked to
    rest, for the friction is more than the load that drives it. Both levels are at least 0 at any load, and in motion
    the torque is the end of the interval of its direction: the law is monotone in omega at a given load, and from each
    state one motion follows.

    Source: worm and screw gears, which lock themselves below the angle of friction; the mesh efficiencies of Pelchen,
    Schweiger, Otter, Modeling and Simulating the Efficiency of Gearboxes and of Planetary Gearboxes (Modelica
    conference 2002).

    Args:
        joint: its name; it must be elastic.
        driving: friction torque over transmission torque where the motor drives the load [1].
        driven: the same where the load drives the motor; 1 or more: self-locking [1].
    """

    sides = ("motor",)
    stage = "dry"
    law = "(driving if tau_s*u > 0 else driven)*abs(tau_s)*Sgn(u)"
    neutral = {"driving": 0.0, "driven": 0.0}
    shown = {"driving": 0.15, "driven": 0.4}
    takes_load = True
    linear = ("driving", "driven")
    contains = ("load_dependent_friction",)
    plainer = ("load_dependent_friction",)
    natural_size = 0.3
    prevalence = "often"

    driving: float = parameter("1", lower=0.0)
    driven: float = parameter("1", lower=0.0)


class StribeckGearLoss(JointEffect):
    """Loss of a gear that falls with speed, in proportion to the load and by the direction of power.

    ``f = (driving if tau_s omega > 0 else driven) exp(-abs(omega)/velocity) abs(tau_s) Sgn(omega)``: what a gear holds
    at rest beyond its `DirectionalGearLoss` in motion. It stands beside that as `StribeckFriction` stands beside
    `CoulombFriction`, and its interval at rest is of the same kind. A diagnosis does not propose it: in the equations
    of motion slow rows alone tell it from the loss in motion, so that it is fitted in simulations.

    Source: the Stribeck part of the load-dependent friction in models M4 to M6 of Duclusaud, Passault, Padois, Ly,
    Extended Friction Models for the Physics Simulation of Servo Actuators (IEEE ICRA 2025).

    Args:
        joint: its name; it must be elastic.
        driving: friction torque over transmission torque at rest where the motor drives the load [1].
        driven: the same where the load drives the motor [1].
        velocity: at which 1/e of it is left [rad/s].
    """

    sides = ("motor",)
    stage = "dry"
    law = "(driving if tau_s*u > 0 else driven)*exp(-abs(u)/velocity)*abs(tau_s)*Sgn(u)"
    neutral = {"driving": 0.0, "driven": 0.0}
    shown = {"driving": 0.3, "driven": 0.2, "velocity": 0.3}
    takes_load = True

    driving: float = parameter("1", lower=0.0)
    driven: float = parameter("1", lower=0.0)
    velocity: float = parameter("rad/s", lower=0.0, strict=True)


class PositionDependentFriction(JointEffect):
    """Dry friction that comes and goes over a turn: an eccentric bearing, teeth of uneven fit.

    ``f = amplitude (1 + sin(harmonic x + phase)) Sgn(u)``, set-valued at rest; it is never negative.

    Args:
        joint: its name.
        side: ``link`` or ``motor``.
        amplitude: mean level, and how far it swings [N m].
        harmonic: cycles per reflected turn; once per motor turn is the gear ratio [1].
        phase: [rad].
    """

    sides = ("link", "motor")
    stage = "dry"
    law = "amplitude*(1 + sin(harmonic*x + phase))*Sgn(u)"
    neutral = {"amplitude": 0.0}
    shown = {"amplitude": 0.5, "harmonic": 2.0, "phase": 0.0}
    contains = ("coulomb_friction",)
    plainer = ("coulomb_friction",)

    amplitude: float = parameter("N m", lower=0.0)
    harmonic: float = parameter("1")
    phase: float = parameter("rad")


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
    stage = "friction"
    law = "stiffness*z + damping*z', z' = u - stiffness*abs(u)*z/level"
    neutral = {"level": 0.0}
    shown = {"level": 1.0, "stiffness": 500.0}
    contains = ("coulomb_friction", "viscous_friction")
    plainer = ("coulomb_friction",)

    level: float = parameter("N m", lower=0.0)
    stiffness: float = parameter("N m/rad", lower=0.0, strict=True)
    damping: float = parameter("N m s/rad", lower=0.0, default=0.0)

    @property
    def reach(self) -> float:
        """Largest bend of the bristles, level/stiffness [rad or m]."""
        return self.level / self.stiffness

    def _torque_of(self, z: NDArray[np.float64], rate: NDArray[np.float64]) -> NDArray[np.float64]:
        return self.stiffness * z + self.damping * rate


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
    stage = "friction"
    law = "coefficient*exp(-t/time_constant)*u"
    neutral = {"coefficient": 0.0}
    shown = {"coefficient": 1.0, "time_constant": 300.0}
    linear = ("coefficient",)
    grids = {"time_constant": ("seconds", spaced(0.04, 1.5, 7))}
    contains = ("viscous_friction",)
    plainer = ("viscous_friction",)

    coefficient: float = parameter("N m s/rad", lower=0.0)
    time_constant: float = parameter("s", lower=0.0, strict=True)
