"""The extent of an arm over its motion: its size, the box that contains it, the path of its tip."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import pinocchio as pin

from flexdyn.arrays import Array, evenly
from flexdyn.robot import Robot
from flexdyn.viewer.bodies import Body, tip_of

EXTENT_SAMPLES = 60
"""Number of times that are used for the extent."""


@dataclass(frozen=True)
class Extent:
    """A box along the axes of the base: its corners (3,) [m]."""

    low: Array
    high: Array

    @property
    def size(self) -> float:
        """Length of its diagonal [m]."""
        return float(np.linalg.norm(self.high - self.low))


def poses(robot: Robot, q: Array) -> Array:
    """Every joint's frame over many positions (samples, m, 4, 4)."""
    model = robot.pin_model
    data = model.createData()
    found = np.empty((len(q), robot.tree.m, 4, 4))
    for i, q_tree in enumerate(robot.expand(q)):
        pin.forwardKinematics(model, data, q_tree)
        for j in range(robot.tree.m):
            found[i, j] = data.oMi[j + 1].homogeneous
    return found


def arm_size(robot: Robot, q: Array) -> float:
    """The size of an arm [m]: the diagonal of the box of all joints, masses and tips over the motion."""
    places = poses(robot, thinned(q))
    local = [(j, point) for j in range(robot.tree.m) for point in (np.zeros(3), robot.tree.com[j], tip_of(robot, j))]
    points = np.concatenate([_moved(places, j, point) for j, point in local] + [np.zeros((1, 3))])
    tree = robot.tree
    heavy = tree.mass > 0
    # A single body at its joint has only the extent of its inertia.
    widths = np.sqrt(6.0 * np.trace(tree.inertia[heavy], axis1=1, axis2=2) / tree.mass[heavy]) if heavy.any() else [0.0]
    return max(float(np.linalg.norm(np.ptp(points, axis=0))), 0.3 * float(np.max(widths)), 1e-3)


def extent(robot: Robot, q: Array, bodies: Sequence[Body]) -> Extent:
    """The box that contains all bodies at all times."""
    places = poses(robot, thinned(q))
    low, high = np.full(3, np.inf), np.full(3, -np.inf)
    for body in bodies:
        points = np.concatenate([_moved(places, body.joint, corner) for corner in body.corners])
        low, high = np.minimum(low, points.min(axis=0)), np.maximum(high, points.max(axis=0))
    return Extent(low, high)


def thinned(q: Array) -> Array:
    """At most `EXTENT_SAMPLES` rows, the first and the last included."""
    return np.asarray(q[evenly(len(q), EXTENT_SAMPLES)])


def _moved(places: Array, joint: int, point: Array) -> Array:
    if joint < 0:
        return point[None, :]
    return np.asarray(places[:, joint, :3, :3] @ point + places[:, joint, :3, 3])
