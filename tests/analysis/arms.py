"""A two-mass system and hand-written matrices of the two-link arm, without Pinocchio."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

import flexdyn as fd
from tests.arms import slider
from tests.oracles.two_link import TwoLink

Array = NDArray[np.float64]
MASS, ROTOR, SPRING, DAMPER = 2.5, 2.0, 800.0, 6.0
WEIGHT = 2.5 * 9.81
"""The slider: link mass [kg], reflected rotor mass [kg], K [N/m], D [N s/m], weight [N]."""


def two_mass(folder: Path, effects: Iterable[Mapping[str, Any]] = (), **drive: float) -> fd.FlexibleJointModel:
    """A mass of 2.5 kg on a vertical slider, driven through a spring by a rotor of 2 kg."""
    numbers = {"gear_ratio": 200.0, "rotor_inertia": 5e-5, "stiffness": SPRING, "damping": DAMPER} | drive
    placed = [{"joint": "lift"} | dict(effect) for effect in effects]
    return fd.FlexibleJointModel(slider(folder), {"lift": numbers}, placed)


def gravity_slope(arm: TwoLink, q: tuple[float, float]) -> Array:
    """DG/dq of the two-link arm (2, 2) [N m/rad], from its weight in closed form."""
    half, length = 0.5 * arm.length, arm.length
    outer = -arm.gravity * (arm.mass * half + arm.tip_mass * length) * math.sin(q[0] + q[1])
    inner = -arm.gravity * (arm.mass * (half + length) + arm.tip_mass * length) * math.sin(q[0])
    return np.array([[inner + outer, outer], [outer, outer]])


def matrices(arm: TwoLink, q: tuple[float, float]) -> tuple[Array, Array, Array]:
    """Inertia (paper, eq. 16-18), stiffness and damping of s = [q1, q2, theta1, theta2], rigid joints without theta."""
    d11, d22, d12, _ = arm.inertias(q[1])
    everything = [0, 1, *(2 + j for j in arm.elastic)]
    rigid = [0.0 if j in arm.elastic else arm.rotor[j] for j in (0, 1)]
    inertia = np.zeros((4, 4))
    inertia[:2, :2] = [[d11 + rigid[0], d12], [d12, d22 + rigid[1]]]
    inertia[2:, 2:] = np.diag(arm.rotor)
    pair = np.array([[1.0, -1.0], [-1.0, 1.0]])
    stiffness, damping = (
        np.kron(pair, np.diag([values[j] if j in arm.elastic else 0.0 for j in (0, 1)]))
        for values in (arm.stiffness, arm.damping)
    )
    stiffness[:2, :2] += gravity_slope(arm, q)
    kept = np.ix_(everything, everything)
    return inertia[kept], stiffness[kept], damping[kept]
