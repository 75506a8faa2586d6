"""The shapes of a robot as a pin.GeometryModel, with all meshes that can be read."""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pinocchio as pin

from flexdyn.robot.joints import RobotJoint
from flexdyn.robot.links import Link
from flexdyn.robot.meshes import MeshWarning
from flexdyn.robot.text import urdf_text


def visual_model(model: pin.Model, links: Sequence[Link], joints: Sequence[RobotJoint]) -> pin.GeometryModel:
    """Build the visual geometry on a normalised model.

    Args:
        model: the model, joints locked or not; a link is found by its frame.
        links: links whose meshes are paths on disk.
        joints: the joints between them.

    Returns:
        The geometry; meshes that cannot be read are left out with one MeshWarning.
    """
    if not links:
        return pin.GeometryModel()
    try:
        return pin.buildGeomFromUrdfString(model, urdf_text(links, joints), pin.GeometryType.VISUAL)
    except (ValueError, RuntimeError):
        readable, unread = _readable(links)
    if not unread:
        raise RuntimeError("Pinocchio refused the shapes of the robot though every mesh can be read")
    warnings.warn(
        f"{len(unread)} meshes cannot be read and are left out of the picture; the first is {unread[0]!r}",
        MeshWarning,
        stacklevel=3,
    )
    return pin.buildGeomFromUrdfString(model, urdf_text(readable, joints), pin.GeometryType.VISUAL)


def _readable(links: Sequence[Link]) -> tuple[list[Link], list[str]]:
    loader = pin.coal.CachedMeshLoader()
    kept, unread = [], []
    for link in links:
        good = []
        for visual in link.visuals:
            if visual.mesh:
                try:
                    loader.load(visual.mesh, np.array(visual.size))
                except (ValueError, RuntimeError):
                    unread.append(visual.mesh)
                    continue
            good.append(visual)
        kept.append(replace(link, visuals=tuple(good)))
    return kept, unread
