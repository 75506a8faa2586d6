"""Forward kinematics of a frame for many positions at once."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from flexdyn import _core
from flexdyn.arrays import Array
from flexdyn.robot.robot import Robot


def frame_positions(robot: Robot, q: ArrayLike, frame: str | None = None) -> Array:
    """Forward kinematics of one frame for many positions.

    The computation goes from the frame to the base. A point x in the frame of joint k has the coordinates ``R_k
    Rot(a_k, q_k) x + t_k`` in the frame of its parent, where ``Rot(a, q) = a a^T + cos(q) (1 - a a^T) + sin(q) S(a)``
    (Rodrigues); for a prismatic joint it is ``R_k (x + q_k a_k) + t_k``. The result for a position does not depend on
    the other positions, to the last bit.

    Args:
        robot: that has the frame.
        q: (..., n) [rad or m].
        frame: its name; default: the last frame of the chain.

    Returns:
        The origin of the frame (..., 3) [m] in the axes of the base.

    Raises:
        InputError: no such frame, or no name although the arm is branched.
    """
    place, tree = robot.frame(robot.tip if frame is None else frame), robot.tree
    positions = np.asarray(q, dtype=np.float64)
    turned = np.ascontiguousarray(robot.expand(positions.reshape(-1, positions.shape[-1])))
    found = np.empty((*positions.shape[:-1], 3))
    way = (tree.parent, tree.prismatic, tree.axis, tree.rotation, tree.translation)
    _core.point_positions(*way, place.joint, place.translation, turned, found)
    return found
