"""The kinematic tree as plain read-only arrays, from which the compiled core rebuilds its model."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields, replace
from typing import Any

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from flexdyn.arrays import Array, Flags
from flexdyn.errors import InputError
from flexdyn.io.locked import Locked, locked_copy
from flexdyn.robot.mimic import Mimic
from flexdyn.robot.motion import motion_of


def spatial(mass: float, com: Array, inertia: Array) -> pin.Inertia:
    """A spatial inertia; Pinocchio's constructor refuses that of a point mass, which differs from zero by rounding."""
    body = pin.Inertia.Zero()
    body.mass, body.lever, body.inertia = mass, np.array(com), np.array(inertia)
    return body


@dataclass(frozen=True, eq=False)
class FramePlacement(Locked):
    """A frame rigidly attached to a joint.

    Attributes:
        name: the frame's name (a URDF link, usually).
        joint: index of the joint in the tree, -1 for the base.
        rotation: its axes in those of the joint, shape (3, 3).
        translation: its origin in the joint frame, shape (3,) [m].
    """

    name: str
    joint: int
    rotation: Array
    translation: Array

    def __post_init__(self) -> None:
        """Copy and lock the arrays."""
        object.__setattr__(self, "rotation", locked_copy(self.rotation))
        object.__setattr__(self, "translation", locked_copy(self.translation))


@dataclass(frozen=True, eq=False, repr=False)
class Tree(Locked):
    """m one-number joints, each with the body it moves, and how the n independent ones drive them.

    q_tree = gain q + offset, v_tree = gain v. Every joint comes after its parent.

    Attributes:
        parent: index of the parent joint, -1 for the base, shape (m,).
        prismatic: whether the joint slides, shape (m,).
        axis: unit axis in the joint frame, shape (m, 3).
        rotation: joint axes in those of the parent joint, shape (m, 3, 3).
        translation: joint origin in the parent joint frame, shape (m, 3) [m].
        mass: mass of the body, shape (m,) [kg].
        com: centre of mass in the joint frame, shape (m, 3) [m].
        inertia: inertia about the centre of mass, along the joint frame's axes, shape (m, 3, 3) [kg m^2].
        armature: added to the diagonal of M, shape (m,) [kg m^2 or kg].
        gain: G of the mimic map, shape (m, n) [1, m/rad or rad/m].
        offset: g0 of the mimic map, shape (m,) [rad or m].
    """

    parent: NDArray[np.int32]
    prismatic: Flags
    axis: Array
    rotation: Array
    translation: Array
    mass: Array
    com: Array
    inertia: Array
    armature: Array
    gain: Array
    offset: Array

    def __post_init__(self) -> None:
        """Copy the arrays and make them read-only."""
        kinds = {"parent": np.int32, "prismatic": np.bool_}
        for field in fields(self):
            value = locked_copy(getattr(self, field.name), kinds.get(field.name, np.float64))
            object.__setattr__(self, field.name, value)

    def __repr__(self) -> str:
        """The number of joints, in one line."""
        return f"<Tree of {self.m} joints, {self.n} of them independent>"

    @property
    def m(self) -> int:
        """Number of joints in the tree, followers included."""
        return len(self.parent)

    @property
    def n(self) -> int:
        """Number of independent joints."""
        return int(self.gain.shape[1])

    @property
    def inertial_parameters(self) -> Array:
        """The numbers of every joint in which torques are linear (m, 11).

        Mass, first moment m c, inertia about the joint's origin ``I + m S(c)`` as xx, xy, yy, xz, yz, zz, and armature.
        """
        shifts = np.array([_steiner(c) for c in self.com]).reshape(-1, 3, 3)
        about = self.inertia + self.mass[:, None, None] * shifts
        rows, columns = (0, 0, 1, 0, 1, 2), (0, 1, 1, 2, 2, 2)
        return np.column_stack([self.mass, self.mass[:, None] * self.com, about[:, rows, columns], self.armature])

    def with_point_mass(self, frame: FramePlacement, mass: float) -> Tree:
        """The tree with a point mass at the origin of a frame (parallel axis theorem).

        With c' = (m c + M p)/(m + M):  I' = I + m S(c - c') + M S(p - c'),  S(d) = (d.d) 1 - d d^T.

        Args:
            frame: position of the mass, from Robot.frame().
            mass: M [kg], 0 or more.

        Returns:
            A new tree.

        Raises:
            InputError: a frame on the base, or no valid mass.
        """
        if not np.isfinite(mass) or mass < 0.0:
            raise InputError("not a mass", key="mass", value=mass, remedy="give it in kg, 0 or more")
        if frame.joint < 0:
            remedy = "name a frame that a joint moves"
            raise InputError("a mass on the base has no effect", key="frame", value=frame.name, remedy=remedy)
        if mass == 0.0:
            return self
        j, point = frame.joint, frame.translation
        total = self.mass[j] + mass
        com = (self.mass[j] * self.com[j] + mass * point) / total
        inertia = self.inertia[j] + self.mass[j] * _steiner(self.com[j] - com) + mass * _steiner(point - com)
        return self._with_body(j, total, com, inertia)

    def with_rotor(self, joint: int, *, prismatic: bool) -> Tree:
        """The tree with an additional joint without a body, on the base, which follows an independent joint.

        Its armature is inertia of that joint alone. It is needed because an axis of coupled drives has no joint of its
        own in the tree.

        Args:
            joint: the independent one.
            prismatic: whether it slides.

        Returns:
            A new tree.
        """
        rows: dict[str, Any] = {"parent": -1, "prismatic": prismatic, "rotation": np.eye(3), "gain": np.zeros(self.n)}
        rows["axis"], rows["gain"][joint] = (0.0, 0.0, 1.0), 1.0
        columns = {field.name: getattr(self, field.name) for field in fields(self)}
        for name, column in columns.items():
            row = np.broadcast_to(rows.get(name, 0.0), column.shape[1:])
            columns[name] = np.concatenate([column, row[None]]).astype(column.dtype)
        return Tree(**columns)

    def with_body_changed(self, joint: int, given: pin.Inertia, true: pin.Inertia) -> Tree:
        """The tree with one part of a body replaced.

        Mass, first moment and inertia about the joint's origin add up over the parts: ``body + true - given``.

        Args:
            joint: that carries the body.
            given: the present part, in the joint frame.
            true: the new part.

        Returns:
            A new tree.
        """
        body = spatial(float(self.mass[joint]), self.com[joint], self.inertia[joint])
        total = body.toDynamicParameters() - given.toDynamicParameters() + true.toDynamicParameters()
        new = pin.Inertia.FromDynamicParameters(total)
        return self._with_body(joint, new.mass, new.lever, new.inertia)

    def carrier(self, j: int) -> int | None:
        """The independent joint that carries another one with none between them; None for the first of an arm.

        Args:
            j: the joint, as in q.
        """
        row = int(self.parent[np.flatnonzero(self.gain[:, j])[0]])
        while row >= 0 and not self.gain[row].any():
            row = int(self.parent[row])
        return int(np.flatnonzero(self.gain[row])[0]) if row >= 0 else None

    def _with_body(self, joint: int, *body: Any) -> Tree:
        """The tree with another mass, centre of mass and inertia of one body."""
        changed = {name: getattr(self, name).copy() for name in ("mass", "com", "inertia")}
        for column, number in zip(changed.values(), body, strict=True):
            column[joint] = number
        return replace(self, **changed)


def tree_of(model: pin.Model, independent: Sequence[str], followers: Mapping[str, Mimic]) -> Tree:
    """The arrays of a normalised model.

    Args:
        model: a model of one-number joints.
        independent: names of the joints that lead, in the order of q.
        followers: leader, multiplier and offset of every other joint.

    Returns:
        The tree.
    """
    joints = range(1, model.njoints)
    motions = [motion_of(model, index) for index in joints]
    column = {name: k for k, name in enumerate(independent)}
    gain, offset = np.zeros((len(joints), len(independent))), np.zeros(len(joints))
    for row, index in enumerate(joints):
        name = model.names[index]
        leader, multiplier, shift = followers.get(name, (name, 1.0, 0.0))
        gain[row, column[leader]], offset[row] = multiplier, shift
    placements, bodies = list(model.jointPlacements)[1:], list(model.inertias)[1:]
    return Tree(
        parent=np.array([model.parents[index] - 1 for index in joints]),
        prismatic=np.array([motion.kind == "prismatic" for motion in motions]),
        axis=np.array([motion.axis for motion in motions]),
        rotation=np.array([placement.rotation for placement in placements]),
        translation=np.array([placement.translation for placement in placements]),
        mass=np.array([body.mass for body in bodies]),
        com=np.array([body.lever for body in bodies]),
        inertia=np.array([body.inertia for body in bodies]),
        armature=np.array(model.armature),
        gain=gain,
        offset=offset,
    )


def _steiner(d: Array) -> Array:
    return np.asarray(np.dot(d, d) * np.eye(3) - np.outer(d, d))
