"""The model that is analysed: corrected numbers, some effects left out."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any

import numpy as np

from flexdyn.arrays import Array
from flexdyn.effects import CommandDelay, Effect, JointCoupling, JointEffect
from flexdyn.model.flexible_joint_model import FlexibleJointModel
from flexdyn.simulation.plant import check_model


def checked_model(model: Any) -> FlexibleJointModel:
    """The model with parameter errors and joint elasticities folded into its numbers, and without command delays.

    A delay is no law of this instant: it changes no torque at rest, and `command_delays` has it for responses. Currents
    follow their voltage at once, without inductance, and dry friction between two motors is left out.

    Raises:
        InputError: the argument is no model.
    """
    check_model(model)
    return _at_once(without(model.resolved(), lambda effect: isinstance(effect, CommandDelay)))


def _at_once(model: FlexibleJointModel) -> FlexibleJointModel:
    """The model without inductance and without dry friction between motors; the same if it has none of them."""
    joints = {}
    for name, joint in model.joints.items():
        if joint.actuator is not None and joint.actuator.dc_motor.inductance > 0.0:
            joints[name] = {"actuator": joint.actuator.changed(inductance=0.0)}
    effects = [each.replace(level=0.0) if isinstance(each, JointCoupling) else each for each in model.effects]
    if not joints and effects == list(model.effects):
        return model
    return model.replace(joints=joints, effects=effects)


def command_delays(model: FlexibleJointModel) -> Array:
    """Dead time between the commanded torque and the motor's (n,) [s]."""
    delays = np.zeros(model.n)
    for effect in model.resolved().effects:
        if isinstance(effect, CommandDelay):
            delays[model.index(effect.joint)] += effect.delay
    return delays


def dry_effects(model: FlexibleJointModel) -> Iterator[tuple[int, JointEffect]]:
    """The dry friction of joints that is not neutral, with each joint's index."""
    for effect in model.all_effects:
        if effect.stage == "dry" and not effect.is_neutral and isinstance(effect, JointEffect):
            yield model.index(effect.joint), effect


def without(model: FlexibleJointModel, leave_out: Callable[[Effect], bool]) -> FlexibleJointModel:
    """The model without some of its effects; the model itself if it has none of them."""
    kept = [effect for effect in model.all_effects if not leave_out(effect)]
    if len(kept) == len(model.all_effects):
        return model
    return model.replace(effects=kept, urdf_dynamics="ignore")
