"""The effects of a model that act in the plant, and their laws for the core."""

from __future__ import annotations

from functools import lru_cache
from typing import Any

import numpy as np

from flexdyn import _core
from flexdyn.effects import CouplingEffect, Effect, JointEffect
from flexdyn.errors import InputError
from flexdyn.model.flexible_joint_model import FlexibleJointModel
from flexdyn.robot.axes import joint_row

# Effects without a law in the plant: they change M and h, numbers of the model, or the measurement.
OTHER_STAGES = ("inertia", "model", "sensor")

# Stages that a law in Python may have, and their sides.
PYTHON_STAGES = {"actuator": ("motor",), "spring": ("transmission",), "friction": ("link", "motor")}


def acting_effects(model: FlexibleJointModel) -> list[Effect]:
    """The effects of a resolved model that have a law in the plant, in the plant's order of laws.

    Actuator effects are in the order in which they act; neutral effects are left out.
    """
    acting = [effect for effect in model.all_effects if not effect.is_neutral and effect.stage not in OTHER_STAGES]
    acting = _gains_added([part for effect in acting for part in effect.parts()])
    return sorted(acting, key=lambda effect: effect.order)


def _gains_added(effects: list[Effect]) -> list[Effect]:
    """One gain of the torque for each joint: gains add, while separate laws would multiply."""
    gains: dict[str, Effect] = {}
    for effect in effects:
        if isinstance(effect, JointEffect) and effect.scales_torque:
            before = gains[effect.joint].torque_gain if effect.joint in gains else 0.0
            gains[effect.joint] = effect.replace(**{effect.scales_torque: before + effect.torque_gain})
    return [*gains.values(), *(effect for effect in effects if not effect.scales_torque)]


def core_law(model: FlexibleJointModel, effect: Effect) -> _core.Law:
    """The law of an effect for the core.

    Raises:
        InputError: an effect that a plant cannot have.
    """
    if not isinstance(effect, JointEffect):
        raise InputError("an effect in the plant acts on a joint", key=effect.name, remedy="derive it from JointEffect")
    side, row = str(effect.side), joint_row(model.robot, effect.joint)
    joint = model.index(effect.joint) if row is None else int(np.flatnonzero(row)[0])
    if effect.is_python:
        _check_stage(effect)
        return _core.python_law(effect.stage, joint, side, _law_call(effect))
    other = model.index(effect.partner) if isinstance(effect, CouplingEffect) else -1
    try:
        return _core_law(effect.name, joint, side, effect.values, other, () if row is None else tuple(row.tolist()))
    except ValueError:
        remedy = "write its law in Python: override torque(self, x, u, *, t, tau)"
        raise InputError("the core has no law of this name", key=effect.name, remedy=remedy) from None


_core_law = lru_cache(maxsize=256)(_core.law)


def _check_stage(effect: JointEffect) -> None:
    """Refuse a law in Python at a stage where the core cannot call it."""
    if effect.stage not in PYTHON_STAGES:
        remedy = f"it is {', '.join(PYTHON_STAGES)}"
        raise InputError("no stage for a law in Python", key=f"{effect.name}.stage", value=effect.stage, remedy=remedy)
    allowed = PYTHON_STAGES[effect.stage]
    if effect.side not in allowed:
        problem = f"a law of stage {effect.stage} does not act on this side"
        raise InputError(problem, key=f"{effect.name}.side", value=effect.side, remedy=f"it is {' or '.join(allowed)}")


def _law_call(effect: JointEffect) -> Any:
    """What the core calls: a law in Python with plain numbers."""

    def call(t: float, x: float, u: float, tau: float) -> float:
        """The law's torque, as a plain number."""
        return float(effect.torque(x, u, t=t, tau=tau))

    return call
