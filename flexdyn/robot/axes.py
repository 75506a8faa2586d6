"""Axes of coupled drives, as in differential wrists and belt-driven elbows: the arm in coordinates of its motors."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

import numpy as np

from flexdyn.arrays import Array
from flexdyn.checks import check_known, number
from flexdyn.errors import InputError

if TYPE_CHECKING:
    from flexdyn.robot.robot import Robot

Axes = Mapping[str, Mapping[str, float]]
SINGULAR = 1e12
"""A matrix with a larger condition number counts as singular [1]."""
KEY = "robot.axes"


def with_axes(robot: Robot, entries: Any, *, ignore_dynamics: bool = False) -> Robot:
    """A robot whose coupled joints are replaced by the axes of their drives.

    With the matrix A of the axes and the positions q_joints of the joints that they name, ``p = A q_joints``; because
    the power is the same, ``tau_joints = A^T tau``. The axes replace the joints in q.

    Args:
        robot: without axes.
        entries: axis -> {joint: coefficient}, as many axes as joints in them.
        ignore_dynamics: whether <dynamics> of the replaced joints is ignored.

    Raises:
        InputError: an unknown joint, a name that exists already, a singular matrix, or <dynamics> of a replaced joint.
    """
    axes = _checked(robot, entries)
    if not axes:
        return robot
    replaced = [joint for joint in robot.joint_names if any(joint in entry for entry in axes.values())]
    A = _matrix(axes, replaced)
    _check_names(robot, axes, replaced)
    places = [robot.joint_names.index(joint) for joint in replaced]
    if not ignore_dynamics:
        _check_dynamics(robot, places)
    gain = np.array(robot.tree.gain)
    gain[:, places] = robot.tree.gain[:, places] @ np.linalg.inv(A)
    gain[np.abs(gain) < np.finfo(float).eps * np.abs(gain).max()] = 0.0
    names, kinds, continuous = list(robot.joint_names), list(robot.kinds), list(robot.continuous)
    for place, (axis, entry) in zip(places, axes.items(), strict=True):
        slides = all(robot.kinds[robot.joint_index(joint)] == "prismatic" for joint in entry)
        names[place], kinds[place], continuous[place] = axis, "prismatic" if slides else "revolute", not slides
    # The joints' limits bound a region that is no box in the axes: `coupled_limits` has those of positions.
    none = {"lower": -np.inf, **dict.fromkeys(("upper", "velocity_limit", "effort_limit"), np.inf)}
    numbers: dict[str, Any] = {name: np.array(getattr(robot, name)) for name in (*none, "damping", "friction")}
    for name, values in numbers.items():
        values[places] = none.get(name, 0.0)
    tree, limits = replace(robot.tree, gain=gain), _limited_joints(robot, places)
    named: Any = {"joint_names": tuple(names), "kinds": tuple(kinds), "continuous": tuple(continuous)}
    return replace(robot, **named, **numbers, tree=tree, axes=axes, coupled_limits=limits)


def _limited_joints(robot: Robot, places: list[int]) -> dict[str, tuple[float, float]]:
    """Joint -> (lower, upper) of joints that are limited."""
    pairs = {robot.joint_names[j]: (float(robot.lower[j]), float(robot.upper[j])) for j in places}
    return {joint: pair for joint, pair in pairs.items() if any(math.isfinite(value) for value in pair)}


def joint_row(robot: Robot, joint: str) -> Array | None:
    """How a joint that axes replace turns with the axes: ``q_joint = row p``, row (n,).

    Args:
        robot: with the axes.
        joint: its name.

    Returns:
        None where the robot has a joint or an axis of this name, or no such joint at all.
    """
    replaced = list(dict.fromkeys(each for entry in robot.axes.values() for each in entry))
    if joint in robot.joint_names or joint not in replaced:
        return None
    row = np.zeros(robot.n)
    inverse = np.linalg.inv(_matrix(robot.axes, replaced))
    row[[robot.joint_index(axis) for axis in robot.axes]] = inverse[replaced.index(joint)]
    row[np.abs(row) < np.finfo(float).eps * np.abs(row).max()] = 0.0
    return row


def plain_axes(axes: Axes) -> dict[str, dict[str, float]]:
    """As a model file writes them."""
    return {axis: dict(entry) for axis, entry in axes.items()}


def _checked(robot: Robot, entries: Any) -> Axes:
    """Check the axes: finite coefficients of known joints; read-only."""
    shape = "write {left: {pitch: 1.0, roll: 1.0}, right: {pitch: 1.0, roll: -1.0}}"
    if not isinstance(entries, Mapping):
        raise InputError("axes are a mapping by name", key=KEY, value=entries, remedy=shape)
    if robot.axes:
        raise InputError("the robot has axes already", key=KEY, remedy="give all of them at once")
    found = {}
    for axis, entry in entries.items():
        if not isinstance(entry, Mapping) or not entry:
            raise InputError("an axis is a mapping of its joints", key=f"{KEY}.{axis}", value=entry, remedy=shape)
        for joint, value in entry.items():
            check_known(joint, robot.joint_names, "the robot has no such joint", key=f"{KEY}.{axis}.{joint}")
            number(f"{KEY}.{axis}.{joint}", value, remedy="it says how far the axis turns with this joint")
        found[str(axis)] = MappingProxyType({str(joint): float(value) for joint, value in entry.items()})
    return MappingProxyType(found)


def _matrix(axes: Axes, replaced: list[str]) -> Array:
    """A of ``p = A q_joints`` (k, k)."""
    if len(axes) != len(replaced):
        value = f"{len(axes)} axes of {len(replaced)} joints"
        remedy = "give as many axes as joints in them: a joint with a motor of its own as {axis: {joint: 1.0}}"
        raise InputError("the matrix of the axes is not square", key=KEY, value=value, remedy=remedy)
    A = np.array([[entry.get(joint, 0.0) for joint in replaced] for entry in axes.values()])
    if not np.linalg.cond(A) < SINGULAR:
        remedy = "the axes must determine every position of the joints"
        raise InputError("the matrix of the axes has no inverse", key=KEY, value=A.tolist(), remedy=remedy)
    return A


def _check_names(robot: Robot, axes: Axes, replaced: list[str]) -> None:
    """Check the names: an axis may have the name of a joint that it replaces, but of no other joint."""
    taken = {*robot.joint_names, *robot.followers} - set(replaced)
    for axis in axes:
        if axis in taken or "." in axis or not axis:
            remedy = "take a name that no other joint has, without a dot"
            raise InputError("the name is taken or no name", key=KEY, value=axis, remedy=remedy)


def _check_dynamics(robot: Robot, places: list[int]) -> None:
    """Refuse friction in the bearings of coupled joints: it acts on several axes at once, which no effect does."""
    for place in places:
        if robot.damping[place] > 0.0 or robot.friction[place] > 0.0:
            joint = robot.joint_names[place]
            remedy = "set robot.urdf_dynamics: ignore, and give friction of the drives as effects of the axes"
            raise InputError(f"<dynamics> of {joint} acts on several axes", key=KEY, remedy=remedy)
