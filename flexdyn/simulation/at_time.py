"""A model whose time begins later: laws that depend on the time since the start of the run."""

from __future__ import annotations

import copy
import math
from typing import Any

from flexdyn.effects import Effect
from flexdyn.model.flexible_joint_model import FlexibleJointModel


def at_time(model: FlexibleJointModel, begin: float) -> FlexibleJointModel:
    """The model as it is from a time on, that time being its new zero [s]."""
    return model.replace(effects=[_moved(each, begin) for each in model.all_effects], urdf_dynamics="ignore")


def is_timed(effect: Effect) -> bool:
    """Whether an effect may depend on the time since the start of the run."""
    return (effect.timed or effect.is_python) and not effect.is_neutral


def _moved(effect: Effect, begin: float) -> Effect:
    """The effect whose zero of time is this later time."""
    if not effect.is_python:
        return effect.later(begin)
    moved = copy.copy(effect)
    law = effect.torque

    def torque(x: float, u: float, *, t: float, tau: float) -> Any:
        """The law at the shifted time; NaN where it fails."""
        try:
            return law(x, u, t=t + begin, tau=tau)
        except Exception:  # a user's code may raise anything, far from the data: the run has failed
            return math.nan

    object.__setattr__(moved, "torque", torque)
    return moved
