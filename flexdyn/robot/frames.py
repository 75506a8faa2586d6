"""Frames of a robot: which joint carries a frame, and which frame is the last on a joint."""

from __future__ import annotations

import pinocchio as pin

from flexdyn.checks import check_known
from flexdyn.robot.tree import FramePlacement

_ORDER = (
    pin.FrameType.BODY,
    pin.FrameType.OP_FRAME,
    pin.FrameType.JOINT,
    pin.FrameType.FIXED_JOINT,
    pin.FrameType.SENSOR,
)


def find_frame(model: pin.Model, name: str) -> FramePlacement:
    """The joint and placement of a frame; if a link and a joint have the same name, it is the link.

    Args:
        model: of the robot.
        name: a link, joint or other frame.

    Raises:
        InputError: no such frame.
    """
    found = [entry for entry in model.frames if entry.name == name]
    if not found:
        known = tuple(dict.fromkeys(entry.name for entry in model.frames))
        check_known(name, known, "no such frame", key="frame", value=name)
    best = min(found, key=lambda entry: _ORDER.index(entry.type))
    return FramePlacement(name, best.parentJoint - 1, best.placement.rotation, best.placement.translation)


def last_frame(model: pin.Model, joint: int) -> str:
    """The last frame of a body that moves with a joint of the tree; without one, the joint itself.

    Args:
        model: of the robot.
        joint: its index in the tree.
    """
    mounted = [entry for entry in model.frames if entry.parentJoint == joint + 1]
    bodies = [entry.name for entry in mounted if entry.type == pin.FrameType.BODY]
    return str(bodies[-1] if bodies else model.names[joint + 1])
