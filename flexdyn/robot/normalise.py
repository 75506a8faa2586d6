"""Convert any fixed-base pin.Model to one in which every joint is one number: nq = nv = joints."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
import pinocchio as pin

from flexdyn.arrays import Array
from flexdyn.errors import InputError
from flexdyn.robot.links import listed_moments
from flexdyn.robot.mimic import Mimic
from flexdyn.robot.motion import JointMotion, joint_model, motion_of
from flexdyn.robot.values import unfit_name

_UNLIMITED = 1e300
"""Pinocchio writes the largest double where there is no limit."""


@dataclass(frozen=True)
class Normalised:
    """A tree of one-number joints, and additional information from Pinocchio's joint types."""

    model: pin.Model
    continuous: frozenset[str]
    mimics: Mapping[str, Mimic]


def normalise(model: pin.Model) -> Normalised:
    """A model of the same arm with continuous joints as one unwrapped angle and mimics as ordinary joints.

    Joint order, placements, inertias, armature, limits, damping, friction, frames and gravity are kept.

    Args:
        model: a model that Pinocchio read or the user built; it is not changed.

    Returns:
        The new model.

    Raises:
        InputError: a joint of another kind (free-flyer, spherical, planar, helical, composite, ...), a body with an
            impossible mass or inertia, or branches whose joints are not numbered one after the other.
    """
    for name in model.names:
        if problem := unfit_name(name):
            raise InputError(problem, key="joint", value=name, remedy="give it a short plain name")
    _check_order(model)
    motions = [motion_of(model, index) for index in range(1, model.njoints)]
    new = pin.Model()
    new.name, new.gravity = model.name, pin.Motion(model.gravity)
    for index, motion in enumerate(motions, start=1):
        _check_body(model, index)
        placement = pin.SE3(model.jointPlacements[index])
        joint = new.addJoint(model.parents[index], joint_model(motion), placement, model.names[index])
        new.appendBodyToJoint(joint, model.inertias[index], pin.SE3.Identity())
    new.inertias[0] = model.inertias[0]
    for frame in list(model.frames)[1:]:
        # The inertias of the joints contain theirs already.
        new.addFrame(frame, False)
    for index in range(1, new.njoints):
        if not new.existFrame(new.names[index], pin.FrameType.JOINT):
            new.addJointFrame(index)
    _copy_numbers(model, new, motions)
    named = list(zip(list(model.names)[1:], motions, strict=True))
    continuous = frozenset(name for name, motion in named if motion.continuous)
    return Normalised(new, continuous, {name: motion.mimic for name, motion in named if motion.mimic is not None})


def _check_order(model: pin.Model) -> None:
    """Refuse subtrees whose joints are not numbered one after the other: Pinocchio's M(q) is wrong for them.

    Source: github.com/stack-of-tasks/pinocchio/issues/1897. A model that Pinocchio reads from a URDF has this order.
    """
    for index in range(2, model.njoints):
        parent, ancestor = model.parents[index], index - 1
        while ancestor > parent:
            ancestor = model.parents[ancestor]
        if ancestor != parent:
            problem = f"it is added to '{model.names[parent]}' after another branch has begun"
            remedy = "add all joints of a branch before those of the next: Pinocchio's M(q) is wrong otherwise"
            raise InputError(problem, key=f"joint '{model.names[index]}'", remedy=remedy)


def _check_body(model: pin.Model, index: int) -> None:
    """Check inertias; rigidly joined links count as one body, so that rounded tiny links are accepted."""
    body, key = model.inertias[index], f"joint '{model.names[index]}'"
    if not np.all(np.isfinite(model.jointPlacements[index].homogeneous)):
        raise InputError("its placement is not finite", key=key, remedy="check the pose that it was added with")
    numbers = np.concatenate([[body.mass], body.lever, body.inertia.ravel()])
    if not np.all(np.isfinite(numbers)) or body.mass < 0.0:
        remedy = "check mass and inertia of the links that it moves"
        raise InputError("the body it moves has no valid mass", key=key, value=float(body.mass), remedy=remedy)
    principal = np.linalg.eigvalsh(body.inertia)
    if principal[0] < -max(1e-12, 1e-6 * principal[2]):
        problem, remedy = "the inertia of the body it moves is not positive semi-definite", "check its links' inertias"
        raise InputError(problem, key=key, value=listed_moments(principal), remedy=remedy)


def _copy_numbers(old: pin.Model, new: pin.Model, motions: list[JointMotion]) -> None:
    """Per-joint arrays; a mimic joint of Pinocchio has none of its own, and gets no limits and no friction."""
    own = [j for j, motion in enumerate(motions) if motion.mimic is None]
    at_q, at_v = ([index[j + 1] for j in own] for index in (old.idx_qs, old.idx_vs))

    def column(values: np.ndarray, at: list[int], otherwise: float) -> np.ndarray:
        """One number of every joint: Pinocchio's where it has one."""
        found = np.full(new.nv, otherwise)
        found[own] = values[at]
        return found

    lower, upper = column(old.lowerPositionLimit, at_q, -np.inf), column(old.upperPositionLimit, at_q, np.inf)
    continuous = [motion.continuous for motion in motions]
    lower[continuous], upper[continuous] = -np.inf, np.inf
    velocity, effort = column(old.velocityLimit, at_v, np.inf), column(old.effortLimit, at_v, np.inf)
    friction = np.zeros(new.nv)
    for j, at in zip(own, at_v, strict=True):
        friction[j] = _friction(old, j + 1, at)
    for limit in (lower, upper, velocity, effort):
        for j in np.flatnonzero(np.isnan(limit)).tolist():
            remedy = "give a number, or inf for no limit"
            raise InputError("a limit is not a number", key=f"joint '{old.names[j + 1]}'/limit", remedy=remedy)
        limit[np.abs(limit) > _UNLIMITED] *= np.inf
    for name in ("armature", "damping", "rotorInertia"):
        values = column(getattr(old, name), at_v, 0.0)
        _check_numbers(old, name, values)
        setattr(new, name, values)
    new.rotorGearRatio = column(old.rotorGearRatio, at_v, 1.0)
    write_limits(new, lower, upper, velocity, effort, friction)


def write_limits(model: pin.Model, lower: Array, upper: Array, velocity: Array, effort: Array, friction: Array) -> None:
    """Set limits and dry friction of every joint of a normalised model, both signs of each.

    Args:
        model: the model to change, with nq = nv = m.
        lower: least position, shape (m,) [rad or m].
        upper: largest position, shape (m,) [rad or m].
        velocity: largest speed, shape (m,) [rad/s or m/s].
        effort: largest torque or force, shape (m,) [N m or N].
        friction: Coulomb level, shape (m,) [N m or N].
    """
    model.lowerPositionLimit, model.upperPositionLimit = lower, upper
    model.lowerVelocityLimit, model.upperVelocityLimit = -velocity, velocity
    model.lowerEffortLimit, model.upperEffortLimit = -effort, effort
    model.lowerDryFrictionLimit, model.upperDryFrictionLimit = -friction, friction


def _friction(model: pin.Model, index: int, at: int) -> float:
    """Pinocchio keeps both directions; setting ``model.friction`` sets the upper one only."""
    upper, lower = float(model.upperDryFrictionLimit[at]), float(model.lowerDryFrictionLimit[at])
    key = f"joint '{model.names[index]}'/friction"
    if not np.isfinite(upper) or upper < 0.0:
        raise InputError("not a friction level", key=key, value=upper, remedy="give a finite level, 0 or more")
    if lower not in (0.0, -upper):
        remedy = "make both directions equal, and add an asymmetric_friction effect"
        raise InputError("friction differs by direction", key=key, value=(lower, upper), remedy=remedy)
    return upper


def _check_numbers(model: pin.Model, name: str, values: np.ndarray) -> None:
    for j, value in enumerate(values):
        if not np.isfinite(value) or value < 0.0:
            key = f"joint '{model.names[j + 1]}'/{name}"
            raise InputError("not a finite number, 0 or more", key=key, value=float(value), remedy=f"set model.{name}")
