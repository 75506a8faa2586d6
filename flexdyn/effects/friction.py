"""Friction: torques that oppose the velocity u of the link or of the rotor, on the left side of the equations."""

from __future__ import annotations

from flexdyn.effects.base import JointEffect, parameter


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

    coefficient: float = parameter("N m s/rad", lower=0.0)


class CoulombFriction(JointEffect):
    """Dry friction of one level, set-valued at rest.

    ``f = level Sgn(u)``, Sgn(0) = [-1, 1]. Paper, eq. 1, second term (b^d); its sgn(0) = 0 (eq. 2) would let a loaded
    joint slide at rest, so the set-valued Sgn stands for it.

    Args:
        joint: its name.
        side: ``link`` or ``motor``.
        level: [N m].
    """

    sides = ("link", "motor")
    stage = "dry"
    law = "level*Sgn(u)"
    neutral = {"level": 0.0}

    level: float = parameter("N m", lower=0.0)


class StribeckFriction(JointEffect):
    """Dry friction in excess of the kinetic level that fades as the joint gets moving.

    ``f = excess exp(-(|u|/velocity)^exponent) Sgn(u)``. Paper, eq. 1, third term: excess = b^s - b^d, velocity =
    epsilon, exponent 1. The level to break away is this excess and the Coulomb level added up.

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

    excess: float = parameter("N m", lower=0.0)
    velocity: float = parameter("rad/s", lower=0.0, strict=True)
    exponent: float = parameter("1", lower=0.0, strict=True, default=1.0)
