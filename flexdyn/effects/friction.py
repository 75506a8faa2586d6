"""Friction that the velocity u of the link or of the rotor decides: torques that oppose it, left in the equations."""

from __future__ import annotations

from flexdyn.effects.joint_effect import JointEffect
from flexdyn.effects.parameters import parameter, spaced

STRIBECK_EXPONENTS = (1.0, 2.0)
"""Exponents of a Stribeck curve that are tried: Tustin's (1947) and the paper's, and the Gaussian one [1]; Armstrong-
Helouvry, Dupont and Canudas de Wit (Automatica 30, 1994) have both.
"""


class Friction(JointEffect, abstract=True):
    """Friction on the link or on the rotor that the velocity alone decides."""

    sides = ("link", "motor")
    of_velocity = True


class ViscousFriction(Friction):
    """Friction proportional to speed.

    ``f = coefficient u``, u = v (link) or omega (motor). Paper, eq. 1, first term (b^v), and eq. 20, 21 (v_1, v_2).

    Args:
        joint: its name.
        side: ``link`` or ``motor``.
        coefficient: [N m s/rad].
    """

    law = "coefficient*u"
    shown = {"coefficient": 0.5}
    linear = ("coefficient",)
    regressed = "viscous"
    prevalence = "everywhere"

    coefficient: float = parameter("N m s/rad", lower=0.0)


class CoulombFriction(Friction):
    """Dry friction of one level, set-valued at rest.

    ``f = level Sgn(u)``, Sgn(0) = [-1, 1]. Paper, eq. 1, second term (b^d); its sgn(0) = 0 (eq. 2) would let a loaded
    joint start to slide from rest under any torque, so flexdyn uses the set-valued Sgn.

    Args:
        joint: its name.
        side: ``link`` or ``motor``.
        level: [N m].
    """

    words = "Coulomb friction"
    law = "level*Sgn(u)"
    shown = {"level": 1.0}
    linear = ("level",)
    regressed = "coulomb"
    prevalence = "everywhere"

    level: float = parameter("N m", lower=0.0, by_factor=True)


class AsymmetricFriction(Friction):
    """Dry friction with a level for each direction of motion, set-valued at rest.

    ``f = level_positive`` for u > 0, ``-level_negative`` for u < 0, any torque of ``[-level_negative,
    level_positive]`` at rest. Equal levels are Coulomb friction. Different ones are the same as Coulomb friction of the
    mean level and a torque offset of half of ``level_negative - level_positive``.

    Args:
        joint: its name.
        side: ``link`` or ``motor``.
        level_positive: against motion in the positive direction [N m].
        level_negative: against motion in the negative direction [N m].
    """

    law = "(level_positive if u > 0 else level_negative)*Sgn(u)"
    shown = {"level_positive": 1.2, "level_negative": 0.7}
    linear = ("level_positive", "level_negative")
    contains = ("coulomb_friction", "torque_offset")
    plainer = ("coulomb_friction",)
    sum_of = contains

    level_positive: float = parameter("N m", lower=0.0)
    level_negative: float = parameter("N m", lower=0.0)


class StribeckFriction(Friction):
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

    words = "Stribeck friction"
    law = "excess*exp(-(abs(u)/velocity)^exponent)*Sgn(u)"
    shown = {"excess": 0.5, "velocity": 0.1}
    linear = ("excess",)
    grids = {"velocity": ("speed", spaced(0.003, 0.4, 9)), "exponent": ("one", STRIBECK_EXPONENTS)}
    steady = True
    prevalence = "often"

    excess: float = parameter("N m", lower=0.0)
    velocity: float = parameter("rad/s", lower=0.0, strict=True)
    exponent: float = parameter("1", lower=0.0, strict=True, default=1.0, chosen=True)


class AsymmetricViscousFriction(Friction):
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

    law = "(coefficient_positive if u > 0 else coefficient_negative)*u"
    shown = {"coefficient_positive": 0.6, "coefficient_negative": 0.3}
    linear = ("coefficient_positive", "coefficient_negative")
    contains = ("viscous_friction",)
    plainer = ("viscous_friction",)

    coefficient_positive: float = parameter("N m s/rad")
    coefficient_negative: float = parameter("N m s/rad")


class QuadraticDrag(Friction):
    """Drag that grows with the square of the speed: air, oil, grease.

    ``f = coefficient u abs(u)``.

    Args:
        joint: its name.
        side: ``link`` or ``motor``.
        coefficient: [N m s^2/rad^2].
    """

    law = "coefficient*u*abs(u)"
    shown = {"coefficient": 0.3}
    linear = ("coefficient",)
    steady = True

    coefficient: float = parameter("N m s^2/rad^2", lower=0.0)
