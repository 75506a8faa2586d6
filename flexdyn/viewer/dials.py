"""The dial at an elastic joint: a face that turns with the link, its mark, and the needle of the rotor."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
import pinocchio as pin

from flexdyn.arrays import Array
from flexdyn.robot.tree import Tree
from flexdyn.viewer.solids import polygon, sector

FACE, MARK, NEEDLE = "#ffffff", "#1f2937", "#d62728"
RADIUS = 0.055
"""Sizes of a dial, as shares of the arm's size [1]."""


@dataclass(frozen=True)
class DialShape:
    """A flat shape of a dial.

    Attributes:
        name: of its node in the scene.
        geometry: meshcat's, in the plane of x and y; that of the needle moves with the rotor.
        color: web colour.
        opacity: 0 to 1.
        order: drawn in this order over everything else.
    """

    name: str
    geometry: Any
    color: str
    opacity: float
    order: int


def dial_pose(tree: Tree, j: int) -> Array:
    """The pose of a joint's dial in the joint's moving frame (4, 4).

    Its z axis is the joint's axis; for a prismatic joint its x axis is. It is on the axis, half-way between the joint's
    origin and the projection of the parent joint's origin, so that dials of joints with the same origin do not overlap.
    """
    axis = tree.axis[j]
    to_parent = -tree.rotation[j].T @ tree.translation[j]
    along = pin.XAxis if tree.prismatic[j] else pin.ZAxis
    pose = np.eye(4)
    pose[:3, :3] = pin.Quaternion.FromTwoVectors(along, np.array(axis)).toRotationMatrix()
    if not tree.prismatic[j]:
        pose[:3, 3] = 0.5 * float(axis @ to_parent) * axis
    return pose


def face(prismatic: bool, size: float) -> Iterator[DialShape]:
    """The part that is fixed to the link: a disc with a mark at zero, or a rail."""
    r = RADIUS * size
    if prismatic:
        rail = [(-2.2 * r, -0.12 * r), (2.2 * r, -0.12 * r), (2.2 * r, 0.12 * r), (-2.2 * r, 0.12 * r)]
        yield DialShape("face", polygon(rail), FACE, 0.75, 10)
        yield DialShape("mark", polygon(_bar(0.0, r, 0.09 * r)), MARK, 0.95, 12)
        return
    yield DialShape("face", sector(0.0, r, 0.0, 2.0 * np.pi), FACE, 0.5, 10)
    yield DialShape("rim", sector(0.94 * r, r, 0.0, 2.0 * np.pi), MARK, 0.9, 11)
    yield DialShape("mark", polygon([(0.0, -0.05 * r), (r, -0.05 * r), (r, 0.05 * r), (0.0, 0.05 * r)]), MARK, 0.95, 12)


def needle(prismatic: bool, size: float) -> DialShape:
    """The part that moves with the rotor."""
    r = RADIUS * size
    corners = _bar(0.0, 0.9 * r, 0.12 * r) if prismatic else [(0.0, -0.11 * r), (0.98 * r, 0.0), (0.0, 0.11 * r)]
    return DialShape("shape", polygon(corners), NEEDLE, 0.95, 13)


def _bar(x: float, half: float, width: float) -> list[tuple[float, float]]:
    return [(x - width, -half), (x + width, -half), (x + width, half), (x - width, half)]
