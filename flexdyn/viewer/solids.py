"""Shapes that meshcat does not have: a tube along a line, and the dial at an elastic joint.

A dial has a face that turns with the link, a mark on it, and a needle that turns with the rotor.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from flexdyn.arrays import Array
from flexdyn.robot.tree import Tree

FACE, MARK, NEEDLE = "#ffffff", "#1f2937", "#d62728"
RADIUS = 0.055
"""Sizes of a dial, as shares of the arm's size [1]."""


def tube(points: Array, radius: float, sides: int = 8) -> Any:
    """A tube along a polyline: meshcat geometry, or None if the line has no length.

    Args:
        points: (k, 3) [m].
        radius: [m].
        sides: of its cross-section.
    """
    steps = np.linalg.norm(np.diff(points, axis=0), axis=1)
    points = points[np.concatenate([[True], steps > 1e-3 * radius])]
    if len(points) < 2:
        return None
    tangents = np.gradient(points, axis=0)
    tangents /= np.maximum(np.linalg.norm(tangents, axis=1, keepdims=True), 1e-300)
    across = _across(tangents)
    other = np.cross(tangents, across)
    angles = np.linspace(0.0, 2.0 * np.pi, sides, endpoint=False)
    ring = np.cos(angles)[None, :, None] * across[:, None, :] + np.sin(angles)[None, :, None] * other[:, None, :]
    vertices = (points[:, None, :] + radius * ring).reshape(-1, 3)
    return _mesh(np.vstack([vertices, points[:1], points[-1:]]), _skin(len(points), sides))


def _across(tangents: Array) -> Array:
    """Unit vectors normal to the tangents that turn as little as possible from one to the next."""
    normals = np.empty_like(tangents)
    last = np.eye(3)[np.argmin(np.abs(tangents[0]))]
    for k, tangent in enumerate(tangents):
        normal = last - tangent * (tangent @ last)
        length = np.linalg.norm(normal)
        last = normal / length if length > 1e-6 else np.cross(tangent, np.eye(3)[np.argmin(np.abs(tangent))])
        last /= np.linalg.norm(last)
        normals[k] = last
    return normals


def _skin(rings: int, sides: int) -> NDArray[np.uint32]:
    """Triangles between the rings, and a fan over each end, whose centres are the last two vertices."""
    k, i = np.meshgrid(np.arange(rings - 1), np.arange(sides), indexing="ij")
    a, b = k * sides + i, k * sides + (i + 1) % sides
    around = [np.stack([a, b, a + sides], -1), np.stack([b, b + sides, a + sides], -1)]
    turn, start, end = np.arange(sides), rings * sides, (rings - 1) * sides
    caps = [
        np.stack([np.full(sides, start), (turn + 1) % sides, turn], -1),
        np.stack([np.full(sides, start + 1), end + turn, end + (turn + 1) % sides], -1),
    ]
    return np.concatenate([part.reshape(-1, 3) for part in (*around, *caps)]).astype(np.uint32)


def ring(inner: float, outer: float) -> Any:
    """A flat ring in the plane of x and y [m]."""
    count = 64
    angles = np.linspace(0.0, 2.0 * np.pi, count)
    edge = np.column_stack([np.cos(angles), np.sin(angles), np.zeros(count)])
    k = np.arange(count - 1)
    faces = np.concatenate([np.stack([k, k + count, k + 1], -1), np.stack([k + 1, k + count, k + count + 1], -1)])
    return _mesh(np.vstack([inner * edge, outer * edge]), faces.astype(np.uint32))


def polygon(corners: list[tuple[float, float]]) -> Any:
    """A flat convex polygon in the plane of x and y [m]."""
    vertices = np.column_stack([np.array(corners), np.zeros(len(corners))])
    k = np.arange(1, len(corners) - 1)
    return _mesh(vertices, np.stack([np.zeros_like(k), k, k + 1], -1).astype(np.uint32))


def _mesh(vertices: Array, faces: NDArray[np.uint32]) -> Any:
    from meshcat.geometry import TriangularMeshGeometry

    return TriangularMeshGeometry(vertices, faces)


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
        yield DialShape("face", polygon(_bar(0.12 * r, 2.2 * r)), FACE, 0.75, 10)
        yield DialShape("mark", polygon(_bar(r, 0.09 * r)), MARK, 0.95, 12)
        return
    yield DialShape("face", ring(0.0, r), FACE, 0.5, 10)
    yield DialShape("rim", ring(0.94 * r, r), MARK, 0.9, 11)
    yield DialShape("mark", polygon([(0.0, -0.05 * r), (r, -0.05 * r), (r, 0.05 * r), (0.0, 0.05 * r)]), MARK, 0.95, 12)


def needle(prismatic: bool, size: float) -> DialShape:
    """The part that moves with the rotor."""
    r = RADIUS * size
    corners = _bar(0.9 * r, 0.12 * r) if prismatic else [(0.0, -0.11 * r), (0.98 * r, 0.0), (0.0, 0.11 * r)]
    return DialShape("shape", polygon(corners), NEEDLE, 0.95, 13)


def _bar(half: float, width: float) -> list[tuple[float, float]]:
    return [(-width, -half), (width, -half), (width, half), (-width, half)]
