"""The two-link arm with elastic joints in closed form: every torque on links and rotors, written from the contract.

Nothing here knows of flexdyn. The laws, their signs and their order are those of the effects table; the links are the
textbook's planar arm (the paper's eq. 12-19), in the horizontal or the vertical plane.
"""

from __future__ import annotations

from math import copysign, cos, exp, inf, pi, sin, sqrt

import layout as at
from compiled import compiled
from layout import Array

# What `forces` fills in, two numbers each: net torque on link and rotor without dry friction, and its bounds.
NET_LINK, NET_MOTOR, LINK_MOST, LINK_LEAST, MOTOR_MOST, MOTOR_LEAST = 0, 2, 4, 6, 8, 10
M11, M12, M22, MODE_1, MODE_2, TAU_S, DELTA = 12, 13, 14, 15, 16, 17, 19
FORCES = 21


@compiled
def bend(moved: float, before: float, width: float) -> float:
    """Z after a motion, z' = u - abs(u) z/width, exactly: over one direction z depends on the way alone."""
    if moved == 0.0:
        return before
    end = copysign(width, moved)
    return end + (before - end) * exp(-abs(moved) / width)


@compiled
def smooth_friction(P: Array, j: int, side: int, x: float, u: float, t: float, moved: float, z: float) -> float:
    """Friction that is zero at rest, and bristles [N m]; moved is the way since z was true."""
    torque: float = P[j, side + at.VISCOUS] * u + P[j, side + at.QUADRATIC] * u * abs(u)
    torque += P[j, side + at.WARM] * exp(-t / P[j, side + at.WARM_TIME]) * u
    if P[j, side + at.LEVEL] > 0.0:
        reach = P[j, side + at.LEVEL] / P[j, side + at.BRISTLE]
        z = bend(moved, z, reach)
        torque += P[j, side + at.BRISTLE] * z + P[j, side + at.BRISTLE_DAMPING] * (u - abs(u) * z / reach)
    if side == at.MOTOR:
        torque += P[j, at.CUBIC_DRAG] * u * u * u
        torque += P[j, at.PATCHY] * (1.0 + sin(P[j, at.PATCHY_HARMONIC] * x)) * u
    return torque


@compiled
def dry_friction(P: Array, j: int, side: int, x: float, u: float, t: float, tau_s: float) -> tuple[float, float]:
    """Levels of dry friction in the positive and in the negative direction [N m]."""
    both = P[j, side + at.SWING] * (1.0 + sin(P[j, side + at.SWING_HARMONIC] * x + P[j, side + at.SWING_PHASE]))
    if P[j, side + at.EXCESS] != 0.0:
        both += P[j, side + at.EXCESS] * exp(-((abs(u) / P[j, side + at.VELOCITY]) ** P[j, side + at.EXPONENT]))
    if side == at.MOTOR:
        both += P[j, at.WEAR] * t
    both += P[j, side + at.LOAD] * abs(tau_s)
    return P[j, side + at.POSITIVE] + both, P[j, side + at.NEGATIVE] + both


@compiled
def wound(P: Array, j: int, q: float, theta: float) -> float:
    """Deflection after kinematic error and dead zone [rad]."""
    delta = theta - q
    if P[j, at.ERROR] != 0.0:
        delta += P[j, at.ERROR] * sin(P[j, at.ERROR_HARMONIC] * theta + P[j, at.ERROR_PHASE])
    gap: float = P[j, at.HALF_GAP]
    return delta - gap if delta > gap else delta + gap if delta < -gap else 0.0


@compiled
def spring(P: Array, j: int, delta: float, t: float, delta_before: float, h: float) -> float:
    """Torque of all springs on the link [N m]."""
    K = P[j, at.K] * (1.0 + P[j, at.BREATHING] * sin(2.0 * pi * P[j, at.BREATHING_RATE] * t))
    torque: float = K * delta + P[j, at.CUBIC] * delta * delta * delta
    if P[j, at.HYSTERESIS] > 0.0:
        torque += P[j, at.HYSTERESIS] * bend(delta - delta_before, h, P[j, at.WIDTH])
    return torque


@compiled
def motor_torque(P: Array, j: int, tau: float, theta: float, omega: float, t: float) -> float:
    """What the motor gives of the torque that has arrived: gain, offset, ripple, limit [N m]."""
    torque: float = (1.0 + P[j, at.GAIN] - P[j, at.SAG] * abs(omega)) * tau + P[j, at.OFFSET]
    torque += P[j, at.RIPPLE] * sin(P[j, at.RIPPLE_HARMONIC] * theta + P[j, at.RIPPLE_PHASE])
    stall = P[j, at.STALL]
    if stall < inf:
        torque = min(torque, max(0.0, stall * (1.0 - omega / P[j, at.NO_LOAD])))
        torque = max(torque, min(0.0, -stall * (1.0 + omega / P[j, at.NO_LOAD])))
    torque += P[j, at.DRIFT] * t + P[j, at.FAN] * sin(2.0 * pi * P[j, at.FAN_RATE] * t)
    return torque


@compiled
def on_link(P: Array, j: int, q: float, v: float, other: float) -> float:
    """Springs, cables and stops between a link and the one before it, on the right side [N m]."""
    torque: float = -P[j, at.PARALLEL] * (q - P[j, at.REST]) - P[j, at.COS_1] * cos(q) - P[j, at.SIN_1] * sin(q)
    torque -= P[j, at.COS_2] * cos(2.0 * q) + P[j, at.SIN_2] * sin(2.0 * q)
    torque -= P[j, at.CABLE] * sin(q) * other + P[j, at.PULL]
    if q > P[j, at.UPPER]:
        torque += min(0.0, -(P[j, at.STOP] * (q - P[j, at.UPPER]) + P[j, at.STOP_DAMPING] * v))
    if q < P[j, at.LOWER]:
        torque += max(0.0, -(P[j, at.STOP] * (q - P[j, at.LOWER]) + P[j, at.STOP_DAMPING] * v))
    return torque


@compiled
def forces(t: float, y: Array, start: Array, memory: Array, tau: Array, P: Array, links: Array, F: Array) -> None:
    """Fill F; memory holds [bristles of links, of motors, hysteresis] (3, 2) as they were at the state `start`."""
    c = links[at.TURN] * cos(y[1])
    s = links[at.TURN] * sin(y[1])
    F[M11], F[M12], F[M22] = links[at.FIXED] + 2.0 * c, links[at.OUTER] + c, links[at.OUTER]
    F[NET_LINK] = s * y[5] * y[5] + 2.0 * s * y[4] * y[5] - links[at.WEIGHT_1] * cos(y[0])
    F[NET_LINK] -= links[at.WEIGHT_2] * cos(y[0] + y[1])
    F[NET_LINK + 1] = -s * y[4] * y[4] - links[at.WEIGHT_2] * cos(y[0] + y[1])
    for j in range(2):
        rigid = P[j, at.RIGID] > 0.0
        q, v = y[j], y[4 + j]
        theta, omega = (q, v) if rigid else (y[2 + j], y[6 + j])
        first = start[j] if rigid else start[2 + j]
        other = y[5 - j] if P[1 - j, at.RIGID] > 0.0 else y[7 - j]
        torque, damped, factor = 0.0, 0.0, 1.0
        if not rigid:
            F[DELTA + j] = wound(P, j, q, theta)
            torque = spring(P, j, F[DELTA + j], t, wound(P, j, start[j], start[2 + j]), memory[2, j])
            rate = omega - v
            damped = P[j, at.D] * rate + P[j, at.ROOT_DAMPING] * rate / sqrt(abs(rate) + 1e-3)
            if P[j, at.ERROR] != 0.0:
                argument = P[j, at.ERROR_HARMONIC] * theta + P[j, at.ERROR_PHASE]
                factor += P[j, at.ERROR] * P[j, at.ERROR_HARMONIC] * cos(argument)
        F[TAU_S + j] = torque + damped
        net = motor_torque(P, j, tau[j], theta, omega, t) - P[j, at.COUPLING] * other
        net -= smooth_friction(P, j, at.MOTOR, theta, omega, t, theta - first, memory[1, j]) + torque * factor + damped
        F[NET_LINK + j] += F[TAU_S + j] + on_link(P, j, q, v, y[1 - j])
        F[NET_LINK + j] -= smooth_friction(P, j, at.LINK, q, v, t, q - start[j], memory[0, j])
        F[LINK_MOST + j], F[LINK_LEAST + j] = dry_friction(P, j, at.LINK, q, v, t, F[TAU_S + j])
        F[MOTOR_MOST + j], F[MOTOR_LEAST + j] = dry_friction(P, j, at.MOTOR, theta, omega, t, F[TAU_S + j])
        F[NET_MOTOR + j] = net
        if rigid:
            F[NET_LINK + j] += net
            F[M11 + 2 * j] += P[j, at.ROTOR]
            F[LINK_MOST + j] += F[MOTOR_MOST + j]
            F[LINK_LEAST + j] += F[MOTOR_LEAST + j]
    extra_mode(y, P, F)


@compiled
def extra_mode(y: Array, P: Array, F: Array) -> None:
    """A mass on a spring that turns with link 1 or link 2, which the catalogue does not know; at most one."""
    F[MODE_1] = F[MODE_2] = 0.0
    for j in range(2):
        if P[j, at.MODE_INERTIA] > 0.0:
            angle, rate = (y[0], y[4]) if j == 0 else (y[0] + y[1], y[4] + y[5])
            torque = P[j, at.MODE_STIFFNESS] * (y[8] - angle) + P[j, at.MODE_DAMPING] * (y[9] - rate)
            F[NET_LINK] += torque
            if j == 1:
                F[NET_LINK + 1] += torque
            F[MODE_1], F[MODE_2] = y[9], -torque / P[j, at.MODE_INERTIA]
