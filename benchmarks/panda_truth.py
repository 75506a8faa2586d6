"""A Panda of seven rigid joints with friction that sticks: Pinocchio's inertias, impulses within their bounds.

Shares no code with flexdyn's core. In every step the friction impulses p of all joints satisfy ``v = w - A^-1 p`` with
``|p_i| <= dt F_i`` and ``p_i = dt F_i sgn(v_i)`` where v_i is not 0, by projected Gauss-Seidel sweeps.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

Array = NDArray[np.float64]
STEP = 2e-4  # s
RATE = 500.0  # Hz of the recording
MIDDLE = np.array([0.0, -0.78, 0.0, -2.3, 0.0, 1.6, 0.78])  # rad
REACH = np.array([0.8, 0.5, 0.7, 0.5, 0.8, 0.7, 0.9])  # rad
KP = np.array([800.0, 800.0, 600.0, 600.0, 250.0, 150.0, 100.0])  # N m/rad
KD = np.array([60.0, 60.0, 45.0, 45.0, 18.0, 12.0, 9.0])  # N m s/rad
ROTOR = np.array([0.6, 0.6, 0.46, 0.46, 0.2, 0.2, 0.2])  # kg m^2 behind the gear
FINGERS = ("panda_finger_joint1", "panda_finger_joint2")
SWEEPS, CLOSE = 50, 1e-12


@dataclass(frozen=True)
class Friction:
    """Friction of every joint (7,).

    Attributes:
        coulomb: level [N m].
        viscous: [N m s/rad].
        excess, velocity, exponent: of Stribeck curves [N m, rad/s, 1].
        load: share of the torque of gravity [1].
    """

    coulomb: Array
    viscous: Array
    excess: Array
    velocity: Array
    exponent: Array
    load: Array


def true_arm(urdf: Path, rng: np.random.Generator, off: float) -> pin.Model:
    """The arm as it was built: every mass, centre and inertia off by up to a share; the hand is closed."""
    whole = pin.buildModelFromUrdf(str(urdf))
    fingers = [whole.getJointId(name) for name in FINGERS]
    arm = pin.buildReducedModel(whole, fingers, pin.neutral(whole))
    for i in range(1, arm.njoints):
        own, (mass, inertia) = arm.inertias[i], 1.0 + rng.uniform(-off, off, 2)
        lever = own.lever * (1.0 + rng.uniform(-off, off, 3))
        arm.inertias[i] = pin.Inertia(own.mass * mass, lever, own.inertia * mass * inertia)
    return arm


def recorded(
    arm: pin.Model, friction: Friction, seconds: float, rng: np.random.Generator
) -> tuple[Array, Array, Array]:
    """Times (samples,), positions and torques (samples, 7) of a motion of three sines for each joint."""
    data, wanted = arm.createData(), _sines(rng)
    q, v, p = MIDDLE.copy(), np.zeros(7), np.zeros(7)
    tau, weight = np.zeros(7), np.zeros(7)
    rows, every, control = [], round(1.0 / (RATE * STEP)), round(1e-3 / STEP)
    for k in range(round(seconds / STEP)):
        if k % control == 0:
            weight = pin.computeGeneralizedGravity(arm, data, q).copy()
            there, rate = wanted(k * STEP)
            tau = KP * (there - q) + KD * (rate - v) + weight
        if k % every == 0:
            rows.append((k * STEP, q, tau))
        q, v, p = _step(arm, data, friction, (q, v, p), tau, np.abs(weight))
    t, positions, torques = zip(*rows, strict=True)
    return np.array(t), np.array(positions), np.array(torques)


def _sines(rng: np.random.Generator) -> Callable[[float], tuple[Array, Array]]:
    """Wanted positions and speeds as a function of the time."""
    w = 2.0 * np.pi * np.stack([rng.uniform(*span, 7) for span in ((0.08, 0.15), (0.2, 0.35), (0.4, 0.7))], axis=1)
    phase, size = rng.uniform(0.0, 2.0 * np.pi, (7, 3)), np.array([0.6, 0.3, 0.15]) * REACH[:, None]

    def wanted(t: float) -> tuple[Array, Array]:
        up = 1.0 - np.exp(-(t**3))
        x = w * t + phase
        return MIDDLE + up * (size * np.sin(x)).sum(axis=1), up * (size * w * np.cos(x)).sum(axis=1)

    return wanted


def _step(
    arm: pin.Model,
    data: pin.Data,
    friction: Friction,
    state: tuple[Array, Array, Array],
    tau: Array,
    weight: Array,
) -> tuple[Array, Array, Array]:
    """Position, speed and friction impulses after a step."""
    q, v, p = state
    M = pin.crba(arm, data, q)
    A = np.triu(M) + np.triu(M, 1).T + np.diag(ROTOR + STEP * friction.viscous)
    load = tau - pin.nonLinearEffects(arm, data, q, v) - friction.viscous * v
    inverse = np.linalg.inv(A)
    curve = friction.excess * np.exp(-((np.abs(v) / friction.velocity) ** friction.exponent))
    most = STEP * (friction.coulomb + curve + friction.load * weight)
    p = np.clip(p, -most, most)
    free = v + inverse @ (STEP * load)
    speed = free - inverse @ p
    for _ in range(SWEEPS):
        before = speed.copy()
        for i in range(7):
            new = min(max(p[i] + speed[i] / inverse[i, i], -most[i]), most[i])
            speed -= inverse[:, i] * (new - p[i])
            p[i] = new
        if np.abs(speed - before).max() < CLOSE:
            break
    return q + STEP * speed, speed, p
