"""External wrenches, prepared for the core."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import numpy as np

from flexdyn import _core
from flexdyn.control.commands import FrameWrench
from flexdyn.control.samples import Samples
from flexdyn.errors import InputError
from flexdyn.model.flexible_joint_model import FlexibleJointModel


def lower_wrenches(model: FlexibleJointModel, external: Iterable[Any], duration: float) -> list[_core.ExternalWrench]:
    """Prepare external wrenches for the core.

    Raises:
        InputError: an object that is no FrameWrench, or a frame that the robot does not have.
    """
    lowered = []
    for wrench in external:
        if not isinstance(wrench, FrameWrench):
            raise InputError("a FrameWrench is needed", key="external", value=wrench)
        samples = wrench.samples
        if not isinstance(samples, Samples):
            samples = Samples([0.0, duration * (1.0 + 1e-9)], np.array([wrench.constant, wrench.constant]))
        place = model.robot.frame(wrench.frame)
        signal = _core.signal(*samples.pieces(samples.values))
        world = wrench.axes == "world"
        lowered.append(_core.external_wrench(place.joint, place.rotation, place.translation, world, signal))
    return lowered
