"""The laws and the equations of motion written a second time, in plain floats, for planar arms of one or two joints.

Only names and numbers are read from flexdyn's effects; every formula is here. The arm is the shipped scara_two_link:
two uniform rods of 1.05 m and 0.42525 kg and a point mass of 0.1 kg at the tip.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import ode

Array = NDArray[np.float64]
LENGTH, MASS, INERTIA, TIP = 1.05, 0.42525, 0.03906984375, 0.1
NAMES = ("shoulder", "elbow")


def sgn(u: float, eps: float) -> float:
    """The smoothed signum of width eps [rad/s]."""
    return math.tanh(u / eps)


def level(e: Any, x: float, u: float, tau_s: float, direction: float) -> float:
    """Level of a dry law for a direction of motion, 0 for any other law [N m]."""
    if e.name == "coulomb_friction":
        return float(e.level)
    if e.name == "asymmetric_friction":
        return float(e.level_positive if direction > 0 else e.level_negative)
    if e.name == "stribeck_friction":
        return float(e.excess * math.exp(-((abs(u) / e.velocity) ** e.exponent)))
    if e.name == "load_dependent_friction":
        return float(e.coefficient * abs(tau_s))
    if e.name == "directional_gear_loss":
        return float(max(e.driving * direction * tau_s, -e.driven * direction * tau_s))
    if e.name == "stribeck_gear_loss":
        share = math.exp(-abs(u) / e.velocity)
        return float(share * max(e.driving * direction * tau_s, -e.driven * direction * tau_s))
    if e.name == "position_dependent_friction":
        return float(e.amplitude * (1.0 + math.sin(e.harmonic * x + e.phase)))
    return 0.0


def smooth_friction(e: Any, t: float, u: float, other: float) -> float:
    """Friction of a law that is smooth in u and has no memory [N m]."""
    if e.name == "viscous_friction":
        return float(e.coefficient * u)
    if e.name == "asymmetric_viscous_friction":
        return float(max(e.coefficient_positive * u, 0.0) + min(e.coefficient_negative * u, 0.0))
    if e.name == "quadratic_drag":
        return float(e.coefficient * u**2 * np.sign(u))
    if e.name == "warm_up_friction":
        return float(e.coefficient * math.exp(-t / e.time_constant) * u)
    if e.name == "joint_coupling":
        return float(e.coefficient * other)
    return 0.0


def on_link(e: Any, q: float, v: float) -> float:
    """Torque on the link, right side [N m]."""
    if e.name == "parallel_spring":
        return float(e.stiffness * (e.rest - q))
    if e.name == "position_torque":
        angles = (math.cos(q), math.sin(q), math.cos(2 * q), math.sin(2 * q))
        return -sum(float(a * b) for a, b in zip((e.cos_1, e.sin_1, e.cos_2, e.sin_2), angles, strict=True))
    if e.name == "end_stop":
        if q > e.upper:
            return float(min(0.0, -e.stiffness * (q - e.upper) - e.damping * v))
        if q < e.lower:
            return float(max(0.0, e.stiffness * (e.lower - q) - e.damping * v))
    return 0.0


def motor(effects: Sequence[Any], tau: float, theta: float, omega: float) -> float:
    """tau_applied: gain, offset, ripple, saturation, limit."""
    tau = tau * (1.0 + sum(e.gain for e in effects if e.name == "torque_constant_error"))
    tau = tau + sum(e.offset for e in effects if e.name == "torque_offset")
    ripples = [e for e in effects if e.name == "torque_ripple"]
    tau = tau + sum(e.amplitude * math.sin(e.harmonic * theta + e.phase) for e in ripples)
    for e in effects:
        if e.name == "torque_saturation":
            tau = e.scale * tau / (e.scale + abs(tau))
    for e in effects:
        if e.name == "torque_speed_limit":
            upper = max(0.0, e.stall_torque * (1.0 - omega / e.no_load_speed))
            tau = min(upper, max(-max(0.0, e.stall_torque * (1.0 + omega / e.no_load_speed)), tau))
    return float(tau)


@dataclass(frozen=True)
class Spring:
    """A transmission at one instant: torque on the link, torque on the rotor, rates of its states."""

    link: float
    rotor: float
    rates: list[float] = field(default_factory=list)


@dataclass(frozen=True)
class Arm:
    """An arm of one joint (the elbow locked straight) or two.

    Args:
        stiffness: K of each joint; infinite: rigid.
        damping: D of each.
        rotor: J of each, reflected.
        effects: flexdyn's effects, of which names and numbers are read.
        gravity: along -y of the plane of motion.
        eps: width of the smoothed signum [rad/s].
    """

    stiffness: tuple[float, ...]
    damping: tuple[float, ...]
    rotor: tuple[float, ...]
    effects: tuple[Any, ...] = ()
    gravity: float = 0.0
    eps: float = 0.05

    @property
    def n(self) -> int:
        """Number of joints."""
        return len(self.stiffness)

    @cached_property
    def elastic(self) -> list[int]:
        """Joints with a spring."""
        return [j for j in range(self.n) if math.isfinite(self.stiffness[j])]

    @cached_property
    def _sides(self) -> dict[tuple[int, str], list[Any]]:
        on_joints = [[e for e in self.effects if getattr(e, "joint", None) == name] for name in NAMES]
        sides = ("motor", "transmission", "link")
        return {(j, side): [e for e in on_joints[j] if e.side == side] for j in range(self.n) for side in sides}

    def of(self, joint: int, side: str) -> list[Any]:
        """The effects on one side of a joint."""
        return self._sides[joint, side]

    def _inertias(self, q: Sequence[float]) -> tuple[float, float, float]:
        # M_11, M_12, M_22 of both joints, rotors of rigid joints included.
        half, q2 = LENGTH / 2, (q[1] if self.n == 2 else 0.0)
        cross = (MASS * half + TIP * LENGTH) * LENGTH * math.cos(q2)
        outer = MASS * half**2 + INERTIA + TIP * LENGTH**2
        inner = MASS * half**2 + INERTIA + (MASS + TIP) * LENGTH**2
        rigid = [0.0 if j >= self.n or j in self.elastic else self.rotor[j] for j in (0, 1)]
        return inner + outer + 2 * cross + rigid[0], outer + cross, outer + rigid[1]

    def mass_matrix(self, q: Sequence[float]) -> Array:
        """M(q) of the links, rotors of rigid joints included."""
        first, between, second = self._inertias(q)
        return np.array([[first, between], [between, second]])[: self.n, : self.n]

    def _bias(self, q: Sequence[float], v: Sequence[float]) -> list[float]:
        half, q2, v2 = LENGTH / 2, *((q[1], v[1]) if self.n == 2 else (0.0, 0.0))
        c = (MASS * half + TIP * LENGTH) * LENGTH * math.sin(q2)
        outer = self.gravity * (MASS * half + TIP * LENGTH) * math.cos(q[0] + q2)
        inner = self.gravity * (MASS * half + (MASS + TIP) * LENGTH) * math.cos(q[0])
        return [-c * v2 * (v2 + 2 * v[0]) + inner + outer, c * v[0] ** 2 + outer][: self.n]

    def bias(self, q: Sequence[float], v: Sequence[float]) -> Array:
        """h(q, v): Coriolis, centrifugal and gravity torques."""
        return np.array(self._bias(q, v))

    def accelerations(self, q: Sequence[float], v: Sequence[float], torques: Sequence[float]) -> list[float]:
        """Of the links, M(q) a = torques - h(q, v) [rad/s^2]."""
        first, between, second = self._inertias(q)
        net = [torque - h for torque, h in zip(torques, self._bias(q, v), strict=True)]
        if self.n == 1:
            return [net[0] / first]
        determinant = first * second - between**2
        return [
            (second * net[0] - between * net[1]) / determinant,
            (first * net[1] - between * net[0]) / determinant,
        ]

    def applied(self, j: int, tau: float, theta: float, omega: float) -> float:
        """tau_applied of joint j [N m]."""
        return motor(self.of(j, "motor"), tau, theta, omega)

    def spring(self, j: int, state: Sequence[float], z: Sequence[float]) -> Spring:
        """The transmission of joint j; state is q, theta, v, omega."""
        q, theta, v, omega = state
        effects = self.of(j, "transmission")
        delta, rate, slope = theta - q, omega - v, 1.0
        for e in effects:
            if e.name == "kinematic_error":
                delta += e.amplitude * math.sin(e.harmonic * theta + e.phase)
                slope += e.amplitude * e.harmonic * math.cos(e.harmonic * theta + e.phase)
        rate += (slope - 1.0) * omega
        gap = sum(e.half_gap for e in effects if e.name == "backlash")
        if abs(delta) < gap:
            delta = rate = 0.0
        else:
            delta -= math.copysign(gap, delta)
        torque, rates, states = self.stiffness[j] * delta, [], iter(z)
        for e in effects:
            torque += e.cubic * delta**3 if e.name == "hardening_spring" else 0.0
            if e.name == "spring_hysteresis":
                h = next(states)
                torque += e.stiffness * h
                rates.append(rate - abs(rate) * h / e.width)
        extra = sum(e.coefficient for e in effects if e.name == "transmission_damping")
        damping = (self.damping[j] + extra) * (omega - v)
        return Spring(torque + damping, slope * torque + damping, rates)

    def friction(self, j: int, side: str, t: float, point: Sequence[float], z: Sequence[float]) -> Spring:
        """Friction on one side of joint j; point is x, u, tau_s and omega of the other joint."""
        x, u, tau_s, other = point
        total, rates, states = 0.0, [], iter(z)
        for e in self.of(j, side):
            total += smooth_friction(e, t, u, other) + sgn(u, self.eps) * level(e, x, u, tau_s, math.copysign(1.0, u))
            if e.name == "presliding_friction":
                bend = next(states)
                rate = u - e.stiffness * abs(u) * bend / e.level
                total += e.stiffness * bend + e.damping * rate
                rates.append(rate)
        return Spring(total, total, rates)

    def split(self, x: Sequence[float]) -> tuple[list[float], list[float], list[float], list[float], list[float]]:
        """q, theta, v, omega of every joint, and the internal states."""
        n, e = self.n, self.elastic
        half = n + len(e)
        q, v = list(x[:n]), list(x[half : half + n])
        theta, omega = list(q), list(v)
        for slot, j in enumerate(e):
            theta[j], omega[j] = x[n + slot], x[half + n + slot]
        return q, theta, v, omega, list(x[2 * half :])

    def derivative(self, t: float, x: Sequence[float], tau: Sequence[float]) -> list[float]:
        """X' of x = [q, theta of elastic joints, v, omega of elastic joints, one state of memory at most]."""
        q, theta, v, omega, z = self.split(x)
        drive: list[float] = []
        alpha, rates = [], []
        for j in range(self.n):
            state = (q[j], theta[j], v[j], omega[j])
            other = omega[1 - j] if self.n == 2 else 0.0
            spring = self.spring(j, state, z) if j in self.elastic else Spring(0.0, 0.0)
            rotor = self.friction(j, "motor", t, (theta[j], omega[j], spring.link, other), z)
            link = self.friction(j, "link", t, (q[j], v[j], spring.link, 0.0), z)
            torque = motor(self.of(j, "motor"), tau[j], theta[j], omega[j]) - rotor.link
            if j in self.elastic:
                alpha.append((torque - spring.rotor) / self.rotor[j])
                torque = spring.link
            drive.append(torque - link.link + sum(on_link(e, q[j], v[j]) for e in self.of(j, "link")))
            rates += spring.rates + rotor.rates + link.rates
        return [*v, *(omega[j] for j in self.elastic), *self.accelerations(q, v, drive), *alpha, *rates]


def trajectory(
    f: Callable[[float, Sequence[float]], Sequence[float]], x0: Any, times: Any, max_step: float = math.inf
) -> Array:
    """States at `times`, the first of them the start, by SciPy's compiled DOP853."""
    settings = {"rtol": 1e-12, "atol": 1e-13, "nsteps": 100_000, "max_step": max_step if max_step < math.inf else 0.0}
    solver = ode(lambda t, x: f(t, x.tolist())).set_integrator("dop853", **settings)
    solver.set_initial_value(np.asarray(x0, dtype=float), times[0])
    states = [np.array(x0, dtype=float)]
    for t in times[1:]:
        states.append(np.array(solver.integrate(t)))
        assert solver.successful()
    return np.array(states)
