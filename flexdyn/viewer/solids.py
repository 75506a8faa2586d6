"""Shapes that meshcat does not have: a tube along a line, a dial and its needle."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


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


def sector(inner: float, outer: float, first: float, last: float) -> Any:
    """A flat piece of a ring in the plane of x and y, from one angle to another [m, rad]."""
    count = max(2, int(np.ceil(abs(last - first) / 0.1)) + 1)
    angles = np.linspace(first, last, count)
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
