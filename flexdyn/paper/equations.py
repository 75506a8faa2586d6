"""The paper's equations in closed form, one function each, independent of Pinocchio and of the compiled core.

"The Effect of Friction on the Formulation and Numerical Solution of Elastic Joint Manipulators", Amirkabir 8/30. q1, q2
are the links' angles, q3, q4 the rotors', as in eq. 12-15. Where the print is wrong, the function has the corrected
form, and its docstring names the printed one. `jacobian_as_printed` and `D22_as_printed` keep the printed forms: the
study shows their errors. Every function takes arrays of states, with the joints as the last axis.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from flexdyn.arrays import Array


@dataclass(frozen=True, kw_only=True)
class Arm:
    """The numbers of the two-link arm; the defaults are those of Table I, or chosen if it does not give them.

    Attributes:
        L: length of both links [m]. Table I.
        mu: mass of both links per length [kg/m]. Table I.
        m_L: point mass at the end [kg]. Table I, printed m_e; eq. 16-19 write m_L, I_L = 0.
        K: spring of both joints [N m/rad]. Table I, printed "N/m".
        v: viscous coefficient of both joints, eq. 20, 21 [N m s/rad].
        J: rotor inertia of both joints, reflected [kg m^2]. The paper gives none.
    """

    L: float = 1.05
    mu: float = 0.405
    m_L: float = 0.1
    K: float = 5.5
    v: float = 0.0
    J: float

    @property
    def m(self) -> float:
        """Mass of a link, mu L [kg]."""
        return self.mu * self.L

    @property
    def l_c(self) -> float:
        """Distance of a link's centre of mass from its joint [m]: L/2, because the rods are uniform."""
        return self.L / 2

    @property
    def inertia(self) -> float:
        """I_1 = I_2 of eq. 16-18: mass moment of a slender uniform rod about its centre, m L^2/12 [kg m^2].

        Table I prints an *area* moment instead, 9.9e-12 m^4, which plays no part in the motion of rigid links.
        """
        return self.m * self.L**2 / 12


def D11(arm: Arm, q2: Array) -> Array:
    """Eq. 16 [kg m^2]: inertia that the first joint turns."""
    cosine = np.cos(q2)
    rods = arm.m * arm.l_c**2 + arm.inertia + arm.m * (arm.L**2 + arm.l_c**2 + 2 * arm.L * arm.l_c * cosine)
    return np.asarray(rods + arm.inertia + arm.m_L * 2 * arm.L**2 * (1 + cosine))


def D22(arm: Arm) -> float:
    """Eq. 17 [kg m^2]: inertia that the second joint turns. Printed with I_c2 for l_c2 and I_2 for l_2."""
    return arm.m * arm.l_c**2 + arm.inertia + arm.m_L * arm.L**2


def D22_as_printed(arm: Arm) -> float:
    """Eq. 17 with its last term I_2^2 as printed: in kg^3 m^4 it is no inertia."""
    return arm.m * arm.l_c**2 + arm.inertia + arm.m_L * arm.inertia**2


def D12(arm: Arm, q2: Array) -> Array:
    """Eq. 18 [kg m^2]: the coupling inertia."""
    return np.asarray((arm.m * arm.L * arm.l_c + arm.m_L * arm.L**2) * np.cos(q2) + D22(arm))


def C(arm: Arm, q2: Array) -> Array:
    """Eq. 19 [kg m^2]: the factor of the Coriolis and centrifugal torques."""
    return np.asarray((arm.m * arm.L * arm.l_c + arm.m_L * arm.L**2) * np.sin(q2))


def mass_matrix(arm: Arm, q: Array) -> Array:
    """D(q) of eq. 3 (..., 2, 2) [kg m^2], its entries eq. 16-18."""
    q2 = q[..., 1]
    coupling = D12(arm, q2)
    last = np.broadcast_to(D22(arm), q2.shape)
    return np.stack([np.stack([D11(arm, q2), coupling], -1), np.stack([coupling, last], -1)], -2)


def coriolis(arm: Arm, q: Array, v: Array) -> Array:
    """The terms in C of eq. 12 and 13 (..., 2) [N m]: -C v2^2 - 2 C v1 v2 and +C v1^2."""
    factor, first, second = C(arm, q[..., 1]), v[..., 0], v[..., 1]
    return np.stack([-factor * second**2 - 2 * factor * first * second, factor * first**2], -1)


def link_acceleration(arm: Arm, q: Array, v: Array, torque: Array) -> Array:
    """Eq. 12 and 13 solved for the accelerations of the links (..., 2) [rad/s^2].

    Args:
        arm: its numbers.
        q: link positions (..., 2) [rad].
        v: link velocities (..., 2) [rad/s].
        torque: what the springs and friction leave for the links, -K (q1 - q3) - b1 and so on (..., 2) [N m].
    """
    rest = torque - coriolis(arm, q, v)
    return np.asarray(np.linalg.solve(mass_matrix(arm, q), rest[..., None])[..., 0])


def derivative(arm: Arm, x: Array, tau: Array) -> Array:
    """Eq. 12-15 as first-order equations: x' (..., 8).

    Viscous friction alone (b1 = v1 q1', b2 = v2 q2'). Eq. 14 and 15 are printed with a bar for the two dots of q3, q4.

    Args:
        arm: its numbers.
        x: q1, q2, q3, q4 [rad] and their velocities [rad/s] (..., 8).
        tau: torques on the rotors (..., 2) [N m].
    """
    q, theta, v, omega = x[..., :2], x[..., 2:4], x[..., 4:6], x[..., 6:]
    spring = arm.K * (theta - q)
    return np.concatenate([v, omega, link_acceleration(arm, q, v, spring - arm.v * v), (tau - spring) / arm.J], -1)


def friction(u: ArrayLike, *, viscous: float, static: float, dynamic: float, epsilon: float) -> Array:
    """Eq. 1: b^v u + sgn(u) (b^d + (b^s - b^d) exp(-|u|/epsilon)) [N m], sgn(0) = 0 as eq. 2 prints it.

    Args:
        u: joint velocity [rad/s].
        viscous: b^v [N m s/rad].
        static: b^s [N m].
        dynamic: b^d [N m].
        epsilon: [rad/s].
    """
    u = np.asarray(u, dtype=float)
    return np.asarray(viscous * u + np.sign(u) * (dynamic + (static - dynamic) * np.exp(-np.abs(u) / epsilon)))


def tip(arm: Arm, q: Array) -> Array:
    """Position of the end of the arm (..., 2) [m]; eq. 8-11 are its derivatives."""
    first, both = q[..., 0], q[..., 0] + q[..., 1]
    return np.stack([arm.L * (np.cos(first) + np.cos(both)), arm.L * (np.sin(first) + np.sin(both))], -1)


def jacobian(arm: Arm, q: Array) -> Array:
    """Eq. 8-11 (..., 2, 2) [m]: J_r = d tip/d q.

    Printed: J_r21 = -l1 cos q1 + l2 cos(q1 + q2) (eq. 10, whose first sign is wrong) and J_r22 = I_2 cos(q1 + q2)
    (eq. 11, I_2 for l_2).
    """
    first, both = q[..., 0], q[..., 0] + q[..., 1]
    x_row = np.stack([-arm.L * (np.sin(first) + np.sin(both)), -arm.L * np.sin(both)], -1)
    y_row = np.stack([arm.L * (np.cos(first) + np.cos(both)), arm.L * np.cos(both)], -1)
    return np.stack([x_row, y_row], -2)


def jacobian_as_printed(arm: Arm, q: Array) -> Array:
    """Eq. 8-11 as printed, with the sign of eq. 10 and the I_2 of eq. 11."""
    printed = jacobian(arm, q)
    printed[..., 1, 0] -= 2 * arm.L * np.cos(q[..., 0])
    printed[..., 1, 1] *= arm.inertia / arm.L
    return printed


def jacobian_rate(arm: Arm, q: Array, v: Array) -> Array:
    """Rate of J_r (..., 2, 2) [m/s], which eq. 6 and 7 leave out: the tip accelerates by J_r q'' + (d J_r/dt) q'."""
    first, both = q[..., 0], q[..., 0] + q[..., 1]
    first_rate, both_rate = v[..., 0], v[..., 0] + v[..., 1]
    one = arm.L * np.stack([np.cos(first) * first_rate, np.sin(first) * first_rate], -1)
    two = arm.L * np.stack([np.cos(both) * both_rate, np.sin(both) * both_rate], -1)
    return -np.stack([one + two, two], -1)
