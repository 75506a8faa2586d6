"""The motion of one joint of a pin.Model: one rotation or one translation about an axis; others are refused."""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import Any

import numpy as np
import pinocchio as pin

from flexdyn.errors import InputError
from flexdyn.robot.mimic import Mimic

_ALIGNED = {
    "revolute": (pin.JointModelRX, pin.JointModelRY, pin.JointModelRZ),
    "prismatic": (pin.JointModelPX, pin.JointModelPY, pin.JointModelPZ),
}
_UNALIGNED = {"revolute": pin.JointModelRevoluteUnaligned, "prismatic": pin.JointModelPrismaticUnaligned}
_NAME = re.compile(r"JointModel(?:([RP])(UB)?([XYZ])|(Revolute|Prismatic)(Unbounded)?Unaligned)")
"""Names of Pinocchio's joints that are one rotation or translation: unbounded or not, about any axis."""


@dataclass(frozen=True)
class JointMotion:
    """The motion of one joint: "revolute" or "prismatic", its unit axis, whether it is unbounded, what it mimics."""

    kind: str
    axis: np.ndarray
    continuous: bool = False
    mimic: Mimic | None = None


def motion_of(model: pin.Model, index: int) -> JointMotion:
    """How a joint of a model moves.

    Args:
        model: the model.
        index: the joint's index, from 1.

    Returns:
        How the joint moves.

    Raises:
        InputError: it is not one rotation or one translation.
    """
    kind_name = model.joints[index].shortname()
    if kind_name == "JointModelMimic":
        return _mimic_motion(model, index)
    match = _NAME.fullmatch(kind_name)
    if match is None:
        raise _refused(model.names[index], kind_name)
    kind = "revolute" if (match[1] or match[4])[0] == "R" else "prismatic"
    if match[3]:
        return JointMotion(kind, np.eye(3)["XYZ".index(match[3])], match[2] is not None)
    subspace = _subspace(model, index)
    return JointMotion(kind, subspace[3:] if kind == "revolute" else subspace[:3], match[5] is not None)


def _subspace(model: pin.Model, index: int) -> np.ndarray:
    """Linear and angular velocity per unit of joint velocity; Python cannot read the axis of some joint types."""
    joint = model.joints[index]
    data = joint.createData()
    joint.calc(data, pin.neutral(model))
    return np.array(data.S, dtype=float).reshape(-1)


def _mimic_motion(model: pin.Model, index: int) -> JointMotion:
    """The motion of a mimic joint, from its motion subspace (scaling times axis): Python does not know its type."""
    joint = model.joints[index]
    scaling, offset = float(joint.extract().scaling), float(joint.extract().offset)
    subspace = _subspace(model, index)
    linear, angular = np.linalg.norm(subspace[:3]), np.linalg.norm(subspace[3:])
    name = model.names[index]
    if scaling == 0.0:
        remedy = "give it a multiplier other than 0, or lock the joint with pin.buildReducedModel"
        raise InputError("a mimic joint with scaling 0", key=f"joint '{name}'", remedy=remedy)
    if linear > 0.0 and angular > 0.0:
        raise _refused(name, "JointModelMimic of a helical joint")
    kind, axis = ("revolute", subspace[3:]) if angular > 0.0 else ("prismatic", subspace[:3])
    at = list(model.mimicking_joints).index(index)
    leader = model.names[model.mimicked_joints[at]]
    axis = axis / scaling
    return JointMotion(kind, axis / np.linalg.norm(axis), False, (leader, scaling, offset))


def _refused(name: str, kind_name: str) -> InputError:
    remedy = "flexdyn models fixed-base arms of revolute and prismatic joints; build it from those"
    if kind_name in ("JointModelFreeFlyer", "JointModelPlanar"):
        remedy = "flexdyn models fixed-base arms; build the model without it"
    return InputError(f"a joint of kind {kind_name.removeprefix('JointModel')}", key=f"joint '{name}'", remedy=remedy)


def joint_model(motion: JointMotion) -> Any:
    """The bounded Pinocchio joint of a motion: JointModelRX, ..., JointModelPrismaticUnaligned."""
    for direction, aligned in zip(np.eye(3), _ALIGNED[motion.kind], strict=True):
        if np.array_equal(motion.axis, direction):
            return aligned()
    return _UNALIGNED[motion.kind](motion.axis)
