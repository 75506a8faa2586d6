"""Friction that grows with the torque that the transmission carries."""

from __future__ import annotations

from flexdyn.effects.joint_effect import JointEffect
from flexdyn.effects.parameters import parameter


class GearLoss(JointEffect, abstract=True):
    """Dry friction of a gear, which depends on the torque that it carries."""

    sides = ("motor",)


class LoadDependentFriction(GearLoss):
    """Dry friction in proportion to the torque that the gear carries, set-valued at rest.

    ``f = coefficient abs(tau_s) Sgn(omega)``, tau_s the transmission torque of this instant, damping included. Source:
    the load-dependent losses of worm, harmonic and planetary gears (1 - efficiency, to first order).

    Args:
        joint: its name; it must be elastic.
        coefficient: friction torque over transmission torque [1].
    """

    law = "coefficient*abs(tau_s)*Sgn(u)"
    shown = {"coefficient": 0.15}
    linear = ("coefficient",)
    natural_size = 0.15
    prevalence = "often"

    coefficient: float = parameter("1", lower=0.0)


class DirectionalGearLoss(GearLoss):
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

    law = "(driving if tau_s*u > 0 else driven)*abs(tau_s)*Sgn(u)"
    shown = {"driving": 0.15, "driven": 0.4}
    linear = ("driving", "driven")
    contains = ("load_dependent_friction",)
    plainer = ("load_dependent_friction",)
    natural_size = 0.3
    prevalence = "often"

    driving: float = parameter("1", lower=0.0)
    driven: float = parameter("1", lower=0.0)


class StribeckGearLoss(GearLoss):
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

    words = "Stribeck gear loss"
    law = "(driving if tau_s*u > 0 else driven)*exp(-abs(u)/velocity)*abs(tau_s)*Sgn(u)"
    neutral = {"driving": 0.0, "driven": 0.0}
    shown = {"driving": 0.3, "driven": 0.2, "velocity": 0.3}

    driving: float = parameter("1", lower=0.0)
    driven: float = parameter("1", lower=0.0)
    velocity: float = parameter("rad/s", lower=0.0, strict=True)
