"""Where a frame goes over many samples at once: forward kinematics by arrays."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from flexdyn.robot import Robot

Array = NDArray[np.float64]


def tip_path(robot: Robot, q: Array) -> Array:
    """Forward kinematics of the last frame of the chain; the same as `flexdyn.run.frame_positions`, fast.

    From the tip inwards, a point x given in the frame of joint k is in the frame of its parent
    ``R_k (Rot(a_k, q_k) x) + t_k`` (Rodrigues' formula for the turn), or ``R_k (x + q_k a_k) + t_k`` where it slides.

    Args:
        robot: whose tip it is.
        q: (samples, n) [rad or m].

    Returns:
        The tip (samples, 3) [m] in the axes of the base.

    Raises:
        InputError: the arm is branched and has no one end.
    """
    place, tree = robot.frame(robot.tip), robot.tree
    turned = robot.expand(q)
    point = np.broadcast_to(place.translation, (len(q), 3))
    joint = place.joint
    while joint >= 0:
        axis, angle = tree.axis[joint], turned[:, joint, None]
        if tree.prismatic[joint]:
            point = point + angle * axis
        else:
            along = np.outer(point @ axis, axis)
            point = along + np.cos(angle) * (point - along) + np.sin(angle) * (point @ _across(axis))
        point = point @ tree.rotation[joint].T + tree.translation[joint]
        joint = int(tree.parent[joint])
    return np.asarray(point)


def _across(axis: Array) -> Array:
    """The matrix S of ``x @ S = axis x x`` (3, 3); numpy.cross takes many times as long."""
    a, b, c = axis
    return np.array([[0.0, c, -b], [-c, 0.0, a], [b, -a, 0.0]])
