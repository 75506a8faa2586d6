"""The scene and its animation as meshcat commands, collected instead of being sent to a server."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from flexdyn.arrays import Array
from flexdyn.plots.page import BLUE
from flexdyn.robot import Robot
from flexdyn.robot.tree import Tree
from flexdyn.viewer.bodies import Body
from flexdyn.viewer.solids import DialShape, dial_pose, face, needle, tube

ARM, GHOST = "/arm", "/ghost"
"""Nodes of the arms in the scene's tree; the page makes the second arm from the first."""
VIOLET, SILVER = "#9b30c9", "#99a6ba"
"""Colours of the second arm, and of an arm whose file gives no colour; parts of the arm are `BLUE`."""


@dataclass(frozen=True)
class NodeMove:
    """The motion of a node of the scene.

    Attributes:
        path: of the node.
        axis: unit axis (3,) of its own frame.
        prismatic: whether it moves along the axis and not about it.
        positions: (frames,) [rad or m], unwrapped.
    """

    path: str
    axis: Array
    prismatic: bool
    positions: Array


def commands_of(moves: Sequence[NodeMove], rate: float) -> list[dict[str, Any]]:
    """Commands that put every node at its first position and, with two frames or more, load the animation.

    Args:
        moves: motions of all nodes, with equal numbers of frames.
        rate: frames in a second [Hz].
    """
    from meshcat.animation import Animation, AnimationClip, AnimationTrack
    from meshcat.commands import SetAnimation, SetProperty
    from meshcat.path import Path

    commands, animation = [], Animation(default_framerate=rate)
    for move in moves:
        name, kind, values = _values(move)
        place = Path(tuple(move.path.strip("/").split("/")))
        commands.append(SetProperty(name, values[0], place).lower())
        frames = list(range(len(values)))
        if len(values) > 1:
            if np.ptp(move.positions) == 0.0:
                frames, values = [frames[0], frames[-1]], [values[0], values[-1]]
            animation.clips[place] = AnimationClip({name: AnimationTrack(name, kind, frames, values)}, rate)
    return commands + ([SetAnimation(animation, play=False).lower()] if animation.clips else [])


def _values(move: NodeMove) -> tuple[str, str, list[list[float]]]:
    """Name, type and values of a node's track for three.js."""
    if move.prismatic:
        return "position", "vector3", (move.positions[:, None] * move.axis).tolist()
    half = move.positions[:, None] / 2.0
    return "quaternion", "quaternion", np.hstack([np.sin(half) * move.axis, np.cos(half)]).tolist()


class Window:
    """Replaces meshcat's connection to a server: it collects the commands."""

    def __init__(self) -> None:
        self.commands: list[dict[str, Any]] = []

    def send(self, command: Any) -> None:
        """Keep a command."""
        self.commands.append(command.lower())


class ArmScene:
    """An arm as a tree of meshcat nodes: joints are nested, and only the node ``moved`` of a joint turns or slides.

    Args:
        robot: the arm.
        size: its size [m].

    Attributes:
        dials: nodes of the dials.
    """

    def __init__(self, robot: Robot, size: float) -> None:
        from meshcat import Visualizer

        self._window = Window()
        self._view = Visualizer(window=self._window)
        self._tree = robot.tree
        self._size = size
        self.dials: list[str] = []
        for j in range(robot.tree.m):
            self._view[joint_path(ARM, robot.tree, j)].set_transform(_pose(robot.tree, j))

    @property
    def commands(self) -> list[dict[str, Any]]:
        """The commands that make the scene, in order."""
        return self._window.commands

    def add_bodies(self, bodies: Sequence[Body]) -> None:
        """Put every body on its joint."""
        from meshcat.geometry import MeshPhongMaterial

        for k, body in enumerate(bodies):
            node = self._view[f"{moved_path(ARM, self._tree, body.joint)}/body{k}"]
            red, green, blue = (round(255 * part) for part in body.color[:3])
            color = (red << 16) + (green << 8) + blue
            opacity = body.color[3] if len(body.color) > 3 else 1.0
            # Shapes of a URDF often share a plane: there the first one is drawn in front, to avoid flicker.
            apart = {"polygonOffset": True, "polygonOffsetFactor": 0.2 * k, "polygonOffsetUnits": 16 * k}
            material = MeshPhongMaterial(color=color, opacity=opacity, shininess=15, flatShading=body.faceted, **apart)
            node.set_object(body.geometry, material)
            node.set_transform(body.pose)

    def add_dial(self, j: int, shown: Array) -> NodeMove:
        """Put a dial on a joint of the tree.

        Args:
            j: the joint.
            shown: magnified position of its needle relative to the link's mark (frames,) [rad or m].

        Returns:
            The motion of the needle.
        """
        prismatic = bool(self._tree.prismatic[j])
        node = f"{moved_path(ARM, self._tree, j)}/dial"
        self.dials.append(node)
        self._view[node].set_transform(dial_pose(self._tree, j))
        for part in face(prismatic, self._size):
            self._flat(f"{node}/{part.name}", part)
        self._flat(f"{node}/needle/shape", needle(prismatic, self._size))
        axis = np.array([1.0, 0.0, 0.0] if prismatic else [0.0, 0.0, 1.0])
        return NodeMove(f"{node}/needle", axis, prismatic, shown)

    def add_tip(self, j: int, point: Array) -> None:
        """Mark the point whose path is drawn."""
        from meshcat.geometry import Sphere

        node = self._view[f"{moved_path(ARM, self._tree, j)}/tip"]
        node.set_object(Sphere(0.011 * self._size), _painted(BLUE))
        node.set_transform(_at(point))

    def add_trace(self, name: str, points: Array, color: str) -> None:
        """Draw the path of a tip."""
        line = tube(points, 0.0032 * self._size)
        if line is not None:
            self._view[f"/{name}"].set_object(line, _painted(color))

    def arm_moves(self, arm: str, q_tree: Array) -> list[NodeMove]:
        """The motions of the joints of an arm, from positions of the whole tree (frames, m)."""
        tree = self._tree
        return [
            NodeMove(moved_path(arm, tree, j), tree.axis[j], bool(tree.prismatic[j]), q_tree[:, j])
            for j in range(tree.m)
        ]

    def _flat(self, path: str, part: DialShape) -> None:
        flat = {"transparent": True, "depthTest": False, "depthWrite": False}
        self._view[path].set_object(part.geometry, _painted(part.color, opacity=part.opacity, **flat))
        # meshcat cannot set the drawing order; three.js can.
        self.commands[-1]["object"]["object"]["renderOrder"] = part.order


def joint_path(arm: str, tree: Tree, j: int) -> str:
    """The node at a joint's origin, fixed in the parent's frame."""
    return f"{moved_path(arm, tree, int(tree.parent[j]))}/joint{j}"


def moved_path(arm: str, tree: Tree, j: int) -> str:
    """The node that moves with a joint; for the base (-1) the arm's own node."""
    return arm if j < 0 else f"{joint_path(arm, tree, j)}/moved"


def _pose(tree: Tree, j: int) -> Array:
    pose = _at(tree.translation[j])
    pose[:3, :3] = tree.rotation[j]
    return pose


def _at(point: Array) -> Array:
    pose = np.eye(4)
    pose[:3, 3] = point
    return pose


def _painted(color: str, **look: Any) -> Any:
    """A material that light does not change."""
    from meshcat.geometry import MeshBasicMaterial

    return MeshBasicMaterial(color=int(color[1:], 16), **look)
