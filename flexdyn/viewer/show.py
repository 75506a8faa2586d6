"""Make the page from motions: which arm is solid, which is translucent, what is magnified."""

from __future__ import annotations

import math

import numpy as np

from flexdyn.model.flexible_joint_model import FlexibleJointModel
from flexdyn.robot import frame_positions
from flexdyn.viewer.about import about_it, legend
from flexdyn.viewer.animation import NodeMove
from flexdyn.viewer.bodies import bodies_of
from flexdyn.viewer.frames import Frames, checked_factor, frames_of, magnification
from flexdyn.viewer.layout import arm_size, extent, tip_frame
from flexdyn.viewer.motion import PlayedMotion
from flexdyn.viewer.page import page
from flexdyn.viewer.scene import ARM, BLUE, GHOST, VIOLET, ArmScene

SHOWN_ANGLE = math.radians(25.0)
"""Approximate size of the largest magnified deflection of a revolute joint [rad]."""
SHOWN_SHARE = 0.1
"""The same for a prismatic joint, as a share of the arm's size [1]."""


def show(
    model: FlexibleJointModel, motion: PlayedMotion, ghost: PlayedMotion | None = None, magnify: float | None = None
) -> str:
    """The page of a motion.

    Args:
        model: of the arm.
        motion: of the arm.
        ghost: motion of a translucent second arm.
        magnify: factor of theta - q; default: one that fits the largest deflection.

    Raises:
        InputError: two motions without a common time, or a factor that is not allowed.
    """
    robot, frames = model.robot, frames_of(motion, ghost)
    size = arm_size(robot, frames.everywhere)
    bodies, notes = bodies_of(robot, size)
    factors = _factors(model, motion, size, magnify)
    scene = ArmScene(robot, size)
    scene.add_bodies(bodies)
    frame = tip_frame(robot)
    tips = [frame_positions(robot, each.q, frame) for each in (frames.arm, frames.ghost) if each is not None]
    place = robot.frame(frame)
    scene.add_tip(place.joint, place.translation)
    for name, points, color in zip(("trace", "ghost_trace"), tips, (BLUE, VIOLET), strict=False):
        scene.add_trace(name, points, color)
    dialled = [j for j in range(model.n) if _known(motion, j)]
    scene.animate(_moves(model, frames, dialled, factors, scene), frames.rate)
    about = about_it(model, frames, size, extent(robot, frames.everywhere, bodies), tips)
    about |= legend(frames, frame, factors, scene.dials)
    samples = len(motion.t)
    if len(frames.arm.t) < samples:
        notes += (f"{len(frames.arm.t)} of {samples} samples are in the page, {frames.rate:.4g} in a second",)
    about["notes"] = [*motion.notes, *(() if ghost is None else ghost.notes), *notes]
    return page(motion.label, about, scene.commands)


def _factors(model: FlexibleJointModel, motion: PlayedMotion, size: float, magnify: float | None) -> dict[str, float]:
    """Magnification by unit, for joints whose rotor is shown."""
    given = None if magnify is None else checked_factor(magnify)
    found = {}
    for unit, shown in (("rad", SHOWN_ANGLE), ("m", SHOWN_SHARE * size)):
        columns = [j for j in range(model.n) if model.robot.angle_unit(j) == unit and _known(motion, j)]
        if columns:
            found[unit] = given or magnification(motion.deflection[:, columns], shown)
    return found


def _known(motion: PlayedMotion, j: int) -> bool:
    return bool(np.isfinite(motion.deflection[:, j]).any())


def _moves(
    model: FlexibleJointModel, frames: Frames, dialled: list[int], factors: dict[str, float], scene: ArmScene
) -> list[NodeMove]:
    """The motions of all nodes; adds the dials."""
    robot = model.robot
    moves = scene.arm_moves(ARM, robot.expand(frames.arm.q))
    if frames.ghost is not None:
        moves += scene.arm_moves(GHOST, robot.expand(frames.ghost.q))
    names = list(robot.pin_model.names)[1:]
    for j in dialled:
        shown = factors[robot.angle_unit(j)] * frames.arm.deflection[:, j]
        moves.append(scene.add_dial(names.index(model.joint_names[j]), shown))
    return moves
