"""Torques of cables and hoses, which no entry of the catalogue holds: smooth in two joints' positions, with a memory.

The torque against a link is a sum of waves sin(a q + b q_other + phase), b never zero, and of a bent hose that follows
the joint's way with a lag (Bouc-Wen) as hard as the other joint's position makes it. Weights are such that along the
motion nothing of it is what the catalogue has: a constant, a spring, cos q and sin q, cos 2q and sin 2q, friction, and
what gravity makes of both joints are projected out.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from math import sin

import numpy as np
from compiled import compiled
from layout import Array
from two_link_forces import bend

WAVES = 20
MEMORY = 3  # hoses per joint
OWN, OTHER, PHASE, WEIGHT = range(4)
WIDTH, TURN, ROPE_PHASE, ROPE_WEIGHT = range(4)


@dataclass(frozen=True, eq=False)
class Cables:
    """Cables of an arm of n joints.

    Attributes:
        others: the joint on whose position a joint's cables also depend (n,).
        waves: own and other's wave number, phase [rad], weight [N m] (n, WAVES, 4).
        ropes: width [rad], wave number of the other joint, phase [rad], weight [N m] (n, MEMORY, 4).
    """

    others: Array = field(default_factory=lambda: np.zeros(0))
    waves: Array = field(default_factory=lambda: np.zeros((0, WAVES, 4)))
    ropes: Array = field(default_factory=lambda: np.zeros((0, MEMORY, 4)))


NONE = Cables()


@compiled
def pull(q: Array, last: Array, bent: Array, others: Array, waves: Array, ropes: Array, out: Array) -> None:
    """Torques against the links at q (n,), into out (n,) [N m].

    Args:
        q: positions (n,) [rad].
        last: positions at the sample before (n,) [rad].
        bent: how far the first hose of every joint is bent, brought forward here (n,) [rad].
        others: of `Cables`.
        waves: of `Cables`.
        ropes: of `Cables`.
        out: torques (n,).
    """
    for j in range(len(q)):
        other = q[int(others[j])]
        bent[j] = bend(q[j] - last[j], bent[j], ropes[j, 0, WIDTH])
        torque = 0.0
        for wave in waves[j]:
            torque += wave[WEIGHT] * sin(wave[OWN] * q[j] + wave[OTHER] * other + wave[PHASE])
        for rope in ropes[j]:
            turn = sin(rope[TURN] * other + rope[ROPE_PHASE])
            torque += rope[ROPE_WEIGHT] * bent[j] / rope[WIDTH] * turn
        out[j] = torque


def draw_cables(rng: np.random.Generator, q: Array, others: Array, size: Array) -> Cables:
    """Cables for a motion.

    Args:
        rng: dice.
        q: the motion (samples, n) [rad].
        others: the joint on which each joint's cables also depend (n,).
        size: root mean square of the torque along the motion (n,) [N m].
    """
    n = q.shape[1]
    waves, ropes = np.zeros((n, WAVES, 4)), np.zeros((n, MEMORY, 4))
    for j in range(n):
        waves[j, :, OWN] = rng.uniform(-3.0, 3.0, WAVES)
        waves[j, :, OTHER] = rng.choice([-1.0, 1.0], WAVES) * rng.uniform(0.7, 3.0, WAVES)
        waves[j, :, PHASE] = rng.uniform(-np.pi, np.pi, WAVES)
        ropes[j, :, WIDTH] = rng.uniform(0.2, 0.6)
        ropes[j, :, TURN] = rng.choice([-1.0, 1.0], MEMORY) * rng.uniform(1.0, 3.0, MEMORY)
        ropes[j, :, ROPE_PHASE] = rng.uniform(-np.pi, np.pi, MEMORY)
        shapes = _shapes(q[:, j], q[:, int(others[j])], waves[j], ropes[j])
        weights = _unlike(shapes, _catalogue(q, j, int(others[j])), rng.normal(size=WAVES + MEMORY))
        weights *= size[j] / np.sqrt(np.mean((shapes @ weights) ** 2))
        waves[j, :, WEIGHT], ropes[j, :, ROPE_WEIGHT] = weights[:WAVES], weights[WAVES:]
    return Cables(np.asarray(others, dtype=float), waves, ropes)


def _shapes(q: Array, other: Array, waves: Array, ropes: Array) -> Array:
    """Every wave and hose along the motion at weight one (samples, WAVES + MEMORY)."""
    sines = np.sin(np.outer(q, waves[:, OWN]) + np.outer(other, waves[:, OTHER]) + waves[:, PHASE])
    bent, width = np.zeros(len(q)), float(ropes[0, WIDTH])
    for k in range(1, len(q)):
        bent[k] = bend(float(q[k] - q[k - 1]), float(bent[k - 1]), width)
    hoses = bent[:, None] / ropes[:, WIDTH] * np.sin(np.outer(other, ropes[:, TURN]) + ropes[:, ROPE_PHASE])
    return np.hstack([sines, hoses])


def _catalogue(q: Array, j: int, other: int) -> Array:
    """What a model could make of the same motion (samples, columns)."""
    own = q[:, j]
    step = np.gradient(own)
    alone = [np.ones_like(own), own, step, np.sign(step)]
    alone += [wave(k * own) for k in (1, 2) for wave in (np.cos, np.sin)]
    both = own + q[:, other]
    return np.stack([*alone, np.cos(both), np.sin(both)], axis=1)


def _unlike(shapes: Array, catalogue: Array, weights: Array) -> Array:
    """The nearest weights whose sum has nothing in common with the catalogue's columns."""
    common = (catalogue / np.linalg.norm(catalogue, axis=0)).T @ shapes
    return np.asarray(weights - np.linalg.pinv(common, rcond=1e-6) @ (common @ weights))
