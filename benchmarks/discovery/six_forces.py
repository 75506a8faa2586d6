"""What acts on the joints of the six-joint arm beside MuJoCo's own springs, dampers and dry friction."""

from __future__ import annotations

from math import cos

import layout as at
import numpy as np
from compiled import compiled
from layout import Array
from two_link_forces import dry_friction, motor_torque, on_link, smooth_friction, spring, wound


@compiled
def act(t: float, qpos: Array, qvel: Array, tau: Array, other: Array, P: Array, out: Array) -> None:
    """Forces on links and rotors (2 n,) [N m]; springs only of joints with play, gear errors or hardening.

    tau: torques that have arrived (n,); other: the joint whose rotor drags on this one's, -1: none (n,).
    """
    n = len(tau)
    for j in range(n):
        q, theta, v, omega = qpos[j], qpos[n + j], qvel[j], qvel[n + j]
        out[j] = on_link(P, j, q, v, 0.0) - smooth_friction(P, j, at.LINK, q, v, t, 0.0, 0.0)
        out[n + j] = motor_torque(P, j, tau[j], theta, omega, t)
        out[n + j] -= smooth_friction(P, j, at.MOTOR, theta, omega, t, 0.0, 0.0)
        if other[j] >= 0:
            out[n + j] -= P[j, at.COUPLING] * qvel[n + int(other[j])]
        if bends(P, j):
            torque = spring(P, j, wound(P, j, q, theta), t, 0.0, 0.0)
            factor = 1.0
            if P[j, at.ERROR] != 0.0:
                factor += (
                    P[j, at.ERROR]
                    * P[j, at.ERROR_HARMONIC]
                    * cos(P[j, at.ERROR_HARMONIC] * theta + P[j, at.ERROR_PHASE])
                )
            out[j] += torque
            out[n + j] -= torque * factor


@compiled
def bends(P: Array, j: int) -> bool:
    """Whether this joint's spring is not a plain one."""
    return bool(P[j, at.ERROR] != 0.0 or P[j, at.HALF_GAP] != 0.0 or P[j, at.CUBIC] != 0.0)


@compiled
def carried(t: float, qpos: Array, qvel: Array, P: Array, tau_s: Array) -> None:
    """Torques of the transmissions (n,) [N m]."""
    n = len(tau_s)
    for j in range(n):
        torque = spring(P, j, wound(P, j, qpos[j], qpos[n + j]), t, 0.0, 0.0)
        tau_s[j] = torque + P[j, at.D] * (qvel[n + j] - qvel[j])


@compiled
def dry(t: float, qpos: Array, qvel: Array, P: Array, tau_s: Array, level: Array, shift: Array) -> None:
    """Dry friction as a symmetric level around a shift, on links and rotors (2 n,) [N m]."""
    n = len(tau_s)
    for body in range(2 * n):
        j, side = (body, at.LINK) if body < n else (body - n, at.MOTOR)
        most, least = dry_friction(P, j, side, qpos[body], qvel[body], t, tau_s[j])
        level[body], shift[body] = 0.5 * (most + least), 0.5 * (most - least)


def plain(P: Array) -> Array:
    """Joints whose spring MuJoCo carries itself (n,)."""
    return np.array([not bends(P, j) for j in range(len(P))])
