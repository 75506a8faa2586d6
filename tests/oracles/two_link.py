"""The planar two-link arm in closed form (paper, eq. 12-19), with rotors, springs, gravity and a force at the tip.

Nothing here comes from Pinocchio or flexdyn: floats, cosines and the paper's symbols. Torque balance, with every
motor-side quantity reflected:

    D11 a1 + D12 a2 - C v2^2 - 2 C v1 v2 + G1 + b1 = tau_s1 + tau_e1
    D12 a1 + D22 a2 + C v1^2             + G2 + b2 = tau_s2 + tau_e2
    J omega'               + b_motor = tau_applied - tau_s,     tau_s = K (theta - q) + D (omega - v)
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property

Pair = tuple[float, float]
Friction = Callable[[int, float], float]
Actuator = Callable[[int, float, float], float]


def no_friction(joint: int, u: float) -> float:
    """A joint that turns freely."""
    return 0.0


def ideal(joint: int, tau: float, omega: float) -> float:
    """A motor that gives what is asked."""
    return tau


@dataclass(frozen=True, kw_only=True)
class TwoLink:
    """Two uniform rods of 1.05 m and 0.405 kg/m and a point mass at the tip: Table I of the paper.

    Args:
        stiffness: K of both joints [N m/rad]; infinite: rigid, its J turns with the link.
        damping: D of both [N m s/rad].
        rotor: J of both, reflected [kg m^2].
        tip_mass: m_L [kg].
        gravity: along -y of the plane of motion [m/s^2].
        link_friction: f_link(joint, v).
        motor_friction: f_motor(joint, omega).
        actuator: tau_applied(joint, tau, omega).
    """

    stiffness: Pair = (5.5, 5.5)
    damping: Pair = (0.0, 0.0)
    rotor: Pair = (0.1, 0.1)
    tip_mass: float = 0.1
    gravity: float = 0.0
    link_friction: Friction = no_friction
    motor_friction: Friction = no_friction
    actuator: Actuator = ideal
    length: float = 1.05
    mass: float = 0.405 * 1.05
    inertia: float = 0.405 * 1.05**3 / 12.0

    @cached_property
    def elastic(self) -> tuple[int, ...]:
        """Joints with a spring."""
        return tuple(j for j in (0, 1) if math.isfinite(self.stiffness[j]))

    def inertias(self, q2: float) -> tuple[float, float, float, float]:
        """D11, D22, D12, C of eq. 16-19 (in 17 I2 is read as l2 where it stands for a length)."""
        m1 = m2 = self.mass
        l1 = l2 = self.length
        lc1 = lc2 = 0.5 * self.length
        inertia, m_load = self.inertia, self.tip_mass
        cos, sin = math.cos(q2), math.sin(q2)
        d11 = m1 * lc1**2 + inertia + m2 * (l1**2 + lc2**2 + 2 * l1 * lc2 * cos) + inertia
        d11 += m_load * (l1**2 + l2**2 + 2 * l1 * l2 * cos)
        d22 = m2 * lc2**2 + inertia + m_load * l2**2
        d12 = m2 * l1 * lc2 * cos + m2 * lc2**2 + inertia + m_load * l1 * l2 * cos + m_load * l2**2
        return d11, d22, d12, m2 * l1 * lc2 * sin + m_load * l1 * l2 * sin

    def weight(self, q1: float, q2: float) -> Pair:
        """G1, G2: gravity along -y."""
        half, full = 0.5 * self.length, self.length
        outer = (self.mass * half + self.tip_mass * full) * math.cos(q1 + q2)
        inner = (self.mass * half + self.mass * full + self.tip_mass * full) * math.cos(q1)
        return self.gravity * (inner + outer), self.gravity * outer

    def bias(self, q: Sequence[float], v: Sequence[float]) -> Pair:
        """H(q, v): Coriolis and centrifugal torques of eq. 12, 13, and gravity."""
        return self._bias(self.inertias(q[1])[3], q, v)

    def _bias(self, c: float, q: Sequence[float], v: Sequence[float]) -> Pair:
        g1, g2 = self.weight(q[0], q[1]) if self.gravity else (0.0, 0.0)
        return -c * v[1] ** 2 - 2 * c * v[0] * v[1] + g1, c * v[0] ** 2 + g2

    def tip_torque(self, q: Sequence[float], fx: float, fy: float, mz: float) -> Pair:
        """J^T (force, moment) at the tip, J of eq. 8-11; the sign of l1 cos(q1) in eq. 10 is a misprint."""
        s1, s12 = self.length * math.sin(q[0]), self.length * math.sin(q[0] + q[1])
        c1, c12 = self.length * math.cos(q[0]), self.length * math.cos(q[0] + q[1])
        return (-s1 - s12) * fx + (c1 + c12) * fy + mz, -s12 * fx + c12 * fy + mz

    def accelerations(self, q: Sequence[float], v: Sequence[float], tau: Pair) -> Pair:
        """Link accelerations under link torques; the rotors of rigid joints turn with the links."""
        d11, d22, d12, c = self.inertias(q[1])
        d11 += 0.0 if 0 in self.elastic else self.rotor[0]
        d22 += 0.0 if 1 in self.elastic else self.rotor[1]
        h1, h2 = self._bias(c, q, v)
        r1, r2 = tau[0] - h1, tau[1] - h2
        determinant = d11 * d22 - d12 * d12
        return (d22 * r1 - d12 * r2) / determinant, (d11 * r2 - d12 * r1) / determinant

    def derivative(self, x: Sequence[float], tau: Sequence[float], external: Pair = (0.0, 0.0)) -> list[float]:
        """X' of x = [q, theta of elastic joints, v, omega of elastic joints]."""
        e = self.elastic
        half = 2 + len(e)
        q, v = x[0:2], x[half : half + 2]
        theta, omega = list(q), list(v)
        for slot, j in enumerate(e):
            theta[j], omega[j] = x[2 + slot], x[half + 2 + slot]
        link, rotor = [0.0, 0.0], []
        for j in (0, 1):
            drive = self.actuator(j, tau[j], omega[j]) - self.motor_friction(j, omega[j])
            if j in e:
                spring = self.stiffness[j] * (theta[j] - q[j]) + self.damping[j] * (omega[j] - v[j])
                rotor.append((drive - spring) / self.rotor[j])
                drive = spring
            link[j] = drive - self.link_friction(j, v[j]) + external[j]
        return [*x[half:], *self.accelerations(q, v, (link[0], link[1])), *rotor]

    def energy(self, x: Sequence[float]) -> float:
        """Kinetic, spring and gravitational energy of the elastic arm [J]."""
        q, theta, v, omega = x[0:2], x[2:4], x[4:6], x[6:8]
        d11, d22, d12, _ = self.inertias(q[1])
        kinetic = 0.5 * (d11 * v[0] ** 2 + 2 * d12 * v[0] * v[1] + d22 * v[1] ** 2)
        kinetic += 0.5 * sum(self.rotor[j] * omega[j] ** 2 for j in (0, 1))
        spring = 0.5 * sum(self.stiffness[j] * (theta[j] - q[j]) ** 2 for j in (0, 1))
        half, full = 0.5 * self.length, self.length
        outer = (self.mass * half + self.tip_mass * full) * math.sin(q[0] + q[1])
        inner = (self.mass * half + self.mass * full + self.tip_mass * full) * math.sin(q[0])
        return kinetic + spring + self.gravity * (inner + outer)
