"""The shapes of the links of an arm: those of its URDF, or bodies drawn from its inertias."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from flexdyn.arrays import Array
from flexdyn.robot import Robot
from flexdyn.robot.tree import Tree
from flexdyn.viewer.solids import tube

BODY_GREY = (0.60, 0.65, 0.73, 1.0)
STEEL = (0.35, 0.45, 0.62, 1.0)
SHELL = (0.45, 0.58, 0.80, 0.55)
LARGEST_MESH = 400_000
"""Largest number of triangles of a mesh in a page."""
LARGEST_ARM = 1_500_000
"""Largest number of triangles of an arm in a page."""


@dataclass(frozen=True)
class Body:
    """A shape that moves with a joint.

    Attributes:
        joint: of the tree; -1: the base.
        geometry: meshcat's.
        pose: (4, 4) in the joint's frame.
        color: red, green, blue, opacity.
        corners: of a box that contains it (8, 3), in the joint's frame [m].
        faceted: drawn with flat faces; smooth otherwise.
    """

    joint: int
    geometry: Any
    pose: Array
    color: tuple[float, ...]
    corners: Array
    faceted: bool = False


def bodies_of(robot: Robot, size: float) -> tuple[list[Body], tuple[str, ...]]:
    """Every body of an arm, and notes for the user.

    Args:
        robot: the arm.
        size: its extent, which determines the thickness of drawn bodies [m].

    Returns:
        Bodies, and notes of one sentence each.
    """
    bodies, refused = _shapes(robot)
    seen = {body.joint for body in bodies}
    bare = [j for j in range(robot.tree.m) if j not in seen]
    names = list(robot.pin_model.names)[1:]
    notes = []
    if refused:
        notes.append(f"left out, too large for a page or of a kind that it does not know: {', '.join(refused)}")
    if len(bare) == robot.tree.m:
        notes.append("no link has shapes that can be drawn: bodies are drawn from the inertias")
    elif bare:
        notes.append(f"no shapes, drawn from its inertia: what moves with {', '.join(names[j] for j in bare)}")
    for j in bare:
        bodies += _from_inertia(robot.tree, j, tip_of(robot, j), size)
    if -1 not in seen and bare:
        bodies += _pedestal(robot.tree, size)
    return bodies, tuple(notes)


def tip_of(robot: Robot, joint: int) -> Array:
    """The end of the body on a joint (3,) [m] in its frame: its farthest frame, else the centre of mass."""
    mounted = (entry for entry in robot.pin_model.frames if entry.parentJoint == joint + 1)
    frames = [np.array(entry.placement.translation) for entry in mounted]
    return max([*frames, robot.tree.com[joint]], key=lambda point: float(np.linalg.norm(point)))


def _shapes(robot: Robot) -> tuple[list[Body], list[str]]:
    """The URDF's shapes as read by Pinocchio, converted for meshcat as in Pinocchio's own visualizer."""
    from pinocchio.visualize.meshcat_visualizer import loadMesh, loadPrimitive

    bodies, refused, total = [], [], 0
    for entry in robot.visual_model().geometryObjects:
        triangles = int(getattr(entry.geometry, "num_tris", 0))
        large = triangles > LARGEST_MESH or total + triangles > LARGEST_ARM
        geometry = None if large else loadMesh(entry.geometry) if triangles else loadPrimitive(entry)
        if geometry is None:
            refused.append(str(entry.name))
            continue
        total += triangles
        entry.geometry.computeLocalAABB()
        box = entry.geometry.aabb_local
        pose = np.array(entry.placement.homogeneous)
        color = tuple(float(part) for part in entry.meshColor)
        plain = np.allclose(color, (0.7, 0.7, 0.7, 1.0), atol=1e-3)
        corners, joint = _corners(np.array(box.min_), np.array(box.max_), pose), int(entry.parentJoint) - 1
        bodies.append(Body(joint, geometry, pose, BODY_GREY if plain else color, corners, faceted=triangles > 0))
    return bodies, refused


def _from_inertia(tree: Tree, j: int, tip: Array, size: float) -> list[Body]:
    """The box of uniform density with this inertia, and rods from the joint to the next ones or to the tip."""
    children = [tree.translation[k] for k in range(tree.m) if tree.parent[k] == j]
    bodies = [rod for end in children or [tip] if (rod := _rod(j, np.zeros(3), end, size))]
    if tree.mass[j] > 0.0:
        edges, axes = box_of(tree.mass[j], tree.inertia[j], smallest=0.02 * size, largest=0.8 * size)
        bodies.append(_box(j, edges, axes, tree.com[j]))
    return bodies


def box_of(mass: float, inertia: Array, smallest: float, largest: float) -> tuple[Array, Array]:
    """Edges [m] and axes of the box of uniform density with this mass and inertia: a_i^2 = 6 (I_j + I_k - I_i) / m.

    Args:
        mass: [kg], more than 0.
        inertia: about the centre of mass (3, 3) [kg m^2].
        smallest: shortest edge that is drawn [m].
        largest: longest edge that is drawn [m].

    Returns:
        Edges (3,) and a rotation (3, 3) whose columns are their directions.
    """
    moments, axes = np.linalg.eigh(inertia)
    squares = 6.0 * (moments.sum() - 2.0 * moments) / mass
    if np.linalg.det(axes) < 0.0:
        axes[:, 0] *= -1.0
    return np.clip(np.sqrt(np.maximum(squares, 0.0)), smallest, largest), axes


def _box(j: int, edges: Array, axes: Array, center: Array) -> Body:
    from meshcat.geometry import Box

    pose = np.eye(4)
    pose[:3, :3], pose[:3, 3] = axes, center
    return Body(j, Box([float(edge) for edge in edges]), pose, SHELL, _corners(-edges / 2.0, edges / 2.0, pose))


def _rod(j: int, start: Array, end: Array, size: float) -> Body | None:
    geometry = tube(np.array([start, end]), 0.012 * size)
    if geometry is None:
        return None
    return Body(j, geometry, np.eye(4), STEEL, _corners(np.minimum(start, end), np.maximum(start, end), np.eye(4)))


def _pedestal(tree: Tree, size: float) -> list[Body]:
    """A disc on the ground, and rods from there to the first joints."""
    r = 0.06 * size
    disc = tube(np.array([[0.0, 0.0, 0.0], [0.0, 0.0, -0.02 * size]]), r, sides=32)
    roots = [tree.translation[k] for k in range(tree.m) if tree.parent[k] < 0]
    rods = [rod for end in roots if (rod := _rod(-1, np.zeros(3), end, size))]
    corners = _corners(np.array([-r, -r, -0.02 * size]), np.array([r, r, 0.0]), np.eye(4))
    return [Body(-1, disc, np.eye(4), STEEL, corners), *rods]


def _corners(low: Array, high: Array, pose: Array) -> Array:
    """The corners of a box along the axes of a pose, in the frame in which the pose is given."""
    picks = np.array(np.meshgrid([0, 1], [0, 1], [0, 1])).reshape(3, 8).T
    return np.asarray(np.where(picks == 1, high, low) @ pose[:3, :3].T + pose[:3, 3])
