"""Where a frame goes: forward kinematics of many positions at once."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from flexdyn.robot.robot import Robot
from flexdyn.robot.tree import Floats


def frame_positions(robot: Robot, q: ArrayLike, frame: str | None = None) -> Floats:
    """Forward kinematics of one frame over many positions.

    From the frame inwards, a point x given in the frame of joint k is in that of its parent ``R_k Rot(a_k, q_k) x +
    t_k``, where ``Rot(a, q) = a a^T + cos(q) (1 - a a^T) + sin(q) S(a)`` (Rodrigues), or ``R_k (x + q_k a_k) + t_k``
    where the joint slides. Each position is computed as if it stood alone, to the last bit.

    Args:
        robot: whose frame it is.
        q: (..., n) [rad or m].
        frame: its name; default: the last frame of the chain.

    Returns:
        its origin (..., 3) [m] in the axes of the base.

    Raises:
        InputError: no such frame, or none is named and the arm is branched.
    """
    place, tree = robot.frame(robot.tip if frame is None else frame), robot.tree
    positions = np.asarray(q, dtype=np.float64)
    turned = robot.expand(positions.reshape(-1, positions.shape[-1]))
    point: list[Any] = list(place.translation)
    joint = place.joint
    while joint >= 0:
        axis, rotation, moved = tree.axis[joint], tree.rotation[joint], np.ascontiguousarray(turned[:, joint])
        if tree.prismatic[joint]:
            point = _times(rotation, [x + a * moved for x, a in zip(point, axis, strict=True)])
        else:
            along = np.outer(axis, axis)
            cos, sin = np.cos(moved), np.sin(moved)
            parts = (_times(rotation @ part, point) for part in (along, np.eye(3) - along, _across(axis)))
            point = [fixed + cos * even + sin * odd for fixed, even, odd in zip(*parts, strict=True)]
        point = [x + t for x, t in zip(point, tree.translation[joint], strict=True)]
        joint = int(tree.parent[joint])
    columns = [np.broadcast_to(x, len(turned)) for x in point]
    return np.stack(columns, axis=-1).reshape(*positions.shape[:-1], 3)


def _times(matrix: Floats, point: Sequence[Any]) -> list[Any]:
    """Matrix times points, whose coordinates are columns; zeros, which most entries are on most arms, cost nothing."""
    return [sum((factor * x for factor, x in zip(row, point, strict=True) if factor), start=0.0) for row in matrix]


def _across(axis: Floats) -> Floats:
    """The matrix S of ``S x = axis x x`` (3, 3)."""
    a, b, c = axis
    return np.array([[0.0, -c, b], [c, 0.0, -a], [-b, a, 0.0]])
