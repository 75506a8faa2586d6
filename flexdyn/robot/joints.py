"""A joint of a URDF file: kind, ends, axis, limits, damping, friction and mimic, checked."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

from flexdyn.errors import did_you_mean
from flexdyn.robot.values import attribute_number, fail, name_of, numbers, pose_of

MOVING = ("revolute", "continuous", "prismatic")
_KINDS = (*MOVING, "fixed", "floating", "planar")


@dataclass(frozen=True)
class RobotJoint:
    """A joint of kind revolute, continuous, prismatic or fixed; limits are infinite if the file gives none."""

    name: str
    kind: str
    parent: str
    child: str
    xyz: tuple[float, ...]
    rpy: tuple[float, ...]
    axis: tuple[float, ...]
    lower: float
    upper: float
    velocity: float
    effort: float
    damping: float
    friction: float
    mimic: tuple[str, float, float] | None
    sourceline: int | None


def read_joint(element: Any) -> RobotJoint:
    """Read and check a ``<joint>``.

    Args:
        element: the XML element.

    Returns:
        The joint, with an axis of unit length; limits are infinite if the file gives none.

    Raises:
        InputError: an entry is missing, misspelt, not a number, or of a kind that a fixed-base arm does not have.
    """
    name = name_of(element, "joint")
    key = f"joint '{name}'"
    if name == "universe":
        raise fail(element, key, "this name is taken by the base", remedy="rename the joint")
    kind = _kind(element, key)
    parent, child = (_end(element, key, end) for end in ("parent", "child"))
    xyz, rpy = pose_of(element, key)
    limits, dynamics = _urdf_limits(element, key, kind), _dynamics(element, key)
    axis = _axis(element, key) if kind in MOVING else (1.0, 0.0, 0.0)
    mimic = _mimic(element, key) if kind in MOVING else None
    return RobotJoint(name, kind, parent, child, xyz, rpy, axis, *limits, *dynamics, mimic, element.sourceline)


def _kind(element: Any, key: str) -> str:
    kind = str(element.get("type") or "").strip()
    if kind in ("floating", "planar"):
        remedy = 'flexdyn models fixed-base arms of revolute and prismatic joints; make it type="fixed"'
        raise fail(element, f"{key}/type", f"a {kind} joint", remedy=remedy)
    if kind not in _KINDS:
        raise fail(element, f"{key}/type", "unknown joint type", kind, did_you_mean(kind, (*MOVING, "fixed")))
    return kind


def _end(element: Any, key: str, end: str) -> str:
    found = element.find(end)
    link = "" if found is None else str(found.get("link") or "").strip()
    if not link:
        raise fail(element, f"{key}/{end}", f"has no {end} link", remedy=f'add <{end} link="..."/>')
    return link


def _axis(element: Any, key: str) -> tuple[float, ...]:
    found = element.find("axis")
    if found is None:
        return (1.0, 0.0, 0.0)
    axis = numbers(found, "xyz", f"{key}/axis", 3, None)
    length = math.sqrt(sum(value * value for value in axis))
    if length < 1e-9:
        raise fail(found, f"{key}/axis", "the axis is zero", found.get("xyz"), 'give a direction, such as "0 0 1"')
    return tuple(value / length for value in axis)


def _urdf_limits(element: Any, key: str, kind: str) -> tuple[float, float, float, float]:
    """lower, upper, velocity, effort; without a range there is no limit, and a missing end of a range is 0."""
    found = element.find("limit")
    if found is None or kind == "fixed":
        return -math.inf, math.inf, math.inf, math.inf
    read = [
        attribute_number(found, name, f"{key}/limit/{name}", default, finite=False)
        for name, default in (("lower", 0.0), ("upper", 0.0), ("velocity", math.inf), ("effort", math.inf))
    ]
    lower, upper, velocity, effort = read
    if kind == "continuous" or (found.get("lower") is None and found.get("upper") is None):
        lower, upper = -math.inf, math.inf
    if lower > upper:
        raise fail(found, f"{key}/limit", "lower is above upper", (lower, upper), "exchange the two")
    if velocity < 0.0 or effort < 0.0:
        which = "velocity" if velocity < 0.0 else "effort"
        raise fail(found, f"{key}/limit/{which}", "negative", found.get(which), "give its magnitude")
    return lower, upper, velocity, effort


def _dynamics(element: Any, key: str) -> tuple[float, float]:
    found = element.find("dynamics")
    if found is None:
        return 0.0, 0.0
    read = [attribute_number(found, name, f"{key}/dynamics/{name}", 0.0) for name in ("damping", "friction")]
    for name, value in zip(("damping", "friction"), read, strict=True):
        if value < 0.0:
            raise fail(found, f"{key}/dynamics/{name}", f"negative {name}", value, "friction opposes motion: 0 or more")
    return read[0], read[1]


def _mimic(element: Any, key: str) -> tuple[str, float, float] | None:
    found = element.find("mimic")
    if found is None:
        return None
    leader = str(found.get("joint") or "").strip()
    if not leader:
        raise fail(found, f"{key}/mimic", "names no joint", remedy='write <mimic joint="..."/>')
    multiplier = attribute_number(found, "multiplier", f"{key}/mimic/multiplier", 1.0)
    return leader, multiplier, attribute_number(found, "offset", f"{key}/mimic/offset", 0.0)
