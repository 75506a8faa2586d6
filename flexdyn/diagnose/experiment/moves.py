"""A small library of motions of one joint, within the range of the recordings."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from flexdyn.arrays import Array
from flexdyn.diagnose.experiment.joint_paths import KINDS, MovedJoint, two_digits
from flexdyn.diagnose.experiment.reach import Reach
from flexdyn.model.flexible_joint_model import FlexibleJointModel

MOTION_REST_TIME = 0.4
"""Time of rest at the beginning and the end of every motion [s]."""
VARIED_MOTIONS = 4
"""Number of a joint's motions that are also tried at other poses and with a payload."""


@dataclass(frozen=True, eq=False)
class PlannedMotion:
    """A proposed motion.

    Attributes:
        joint: that moves.
        words: what to do, such as "sweep elbow at 0.2 rad/s ...".
        path: reference positions (samples, n) [rad or m].
        push: torque added to that of the controller (samples, n) [N m or N].
        mass: of a known payload at the tip [kg].
    """

    joint: int
    words: str
    path: Array
    push: Array
    mass: float = 0.0

    def loaded(self, mass: float) -> PlannedMotion:
        """The same with a payload."""
        return replace(self, words=f"{self.words}, with {two_digits(mass)} kg at the tip", mass=mass)


def moves(reach: Reach, j: int, model: FlexibleJointModel, pose: Array, where: str = "") -> list[PlannedMotion]:
    """All motions of one joint, with the others held, the most informative ones first.

    Args:
        reach: bounds from the recordings.
        j: the joint.
        model: of the arm.
        pose: at which the others are held (n,).
        where: that pose in words.
    """
    if not (reach.high[j] > reach.low[j] and reach.speed[j] > 0.0 and reach.acceleration[j] > 0.0):
        return []
    bounds = (reach.low, reach.high, reach.speed, reach.acceleration, reach.torque)
    of = MovedJoint(j, model.joint_names[j], model.robot.angle_unit(j), reach.dt, *(float(each[j]) for each in bounds))
    made = [kind(of) for kind in KINDS]
    return [_placed(of, words + where, x, push, pose) for words, x, push in made if len(x) > 2]


def _placed(joint: MovedJoint, words: str, x: Array, push: Array | None, pose: Array) -> PlannedMotion:
    """A motion of the whole arm, with rest at the beginning and the end."""
    rest = round(MOTION_REST_TIME / joint.dt)
    path = np.repeat(pose[None, :], len(x) + 2 * rest, axis=0)
    path[:, joint.j] = np.concatenate([np.full(rest, x[0]), x, np.full(rest, x[-1])])
    added = np.zeros_like(path)
    if push is not None:
        added[rest:-rest, joint.j] = push
    return PlannedMotion(joint.j, words, path, added)
