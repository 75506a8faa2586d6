"""Positions over time as tracks of meshcat's own animation."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from flexdyn.arrays import Array


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
            track = AnimationTrack(name, kind, frames, values)
            animation.clips[place] = AnimationClip({name: track}, rate)
    return commands + ([SetAnimation(animation, play=False).lower()] if animation.clips else [])


def _values(move: NodeMove) -> tuple[str, str, list[list[float]]]:
    """Name, type and values of a node's track for three.js."""
    if move.prismatic:
        return "position", "vector3", (move.positions[:, None] * move.axis).tolist()
    half = move.positions[:, None] / 2.0
    return "quaternion", "quaternion", np.hstack([np.sin(half) * move.axis, np.cos(half)]).tolist()
