"""Mass, centre of mass and inertia of one link: changed, and its size read."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import pinocchio as pin

from flexdyn.errors import InputError, did_you_mean
from flexdyn.robot.joints import RobotJoint
from flexdyn.robot.links import Inertial, Link, spatial_inertia
from flexdyn.robot.tree import FramePlacement, Tree, spatial


def with_inertial(
    link: str,
    change: Callable[[Inertial], Inertial],
    links: Sequence[Link],
    frame_of: Callable[[str], FramePlacement],
    tree: Tree,
    model: pin.Model,
) -> dict[str, Any]:
    """The parts of a robot in which the mass, centre of mass and inertia of one link are changed.

    Args:
        link: its name.
        change: the new numbers from the present ones.
        links: of the robot.
        frame_of: where a frame stands.
        tree: of the robot.
        model: a copy of the robot's Pinocchio model, which this function changes.

    Returns:
        The robot's fields with their new values.

    Raises:
        InputError: no such link, one without mass, or one that does not move.
    """
    place = {entry.name: k for k, entry in enumerate(links)}.get(link)
    if place is None:
        names = [entry.name for entry in links if entry.inertial is not None]
        remedy = did_you_mean(link, names) if names else "load the robot from a URDF, whose links have numbers"
        raise InputError("no such link", key="link", value=link, remedy=remedy)
    given = links[place].inertial
    frame = frame_of(link)
    if given is None or given.mass == 0.0 or frame.joint < 0:
        problem = "the link has no mass" if frame.joint >= 0 else "the link does not move: its mass has no effect"
        raise InputError(problem, key="link", value=link)
    true = change(given)
    mounted = pin.SE3(frame.rotation, frame.translation)
    parts = [mounted.act(spatial_inertia(body)) for body in (given, true)]
    changed = tree.with_body_changed(frame.joint, *parts)
    j = frame.joint
    model.inertias[j + 1] = spatial(float(changed.mass[j]), changed.com[j], changed.inertia[j])
    others = (*links[:place], replace(links[place], inertial=true), *links[place + 1 :])
    return {"tree": changed, "_model": model, "_links": others}


def size_of(link: str, links: Sequence[Link], joints: Sequence[RobotJoint]) -> tuple[float, float]:
    """Mass of a link [kg], and its length: to its centre of mass or its farthest joint, whichever is larger [m]."""
    given = next(entry.inertial for entry in links if entry.name == link)
    points = [joint.xyz for joint in joints if joint.parent == link]
    xyz, mass = ((0.0, 0.0, 0.0), 0.0) if given is None else (given.xyz, given.mass)
    return mass, max(float(np.linalg.norm(point)) for point in (xyz, *points))
