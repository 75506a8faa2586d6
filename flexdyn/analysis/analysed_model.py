"""The model that is analysed: corrected numbers, some effects left out."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any

import numpy as np

from flexdyn.arrays import Array
from flexdyn.effects import CouplingEffect, Effect, JointEffect
from flexdyn.model.flexible_joint_model import FlexibleJointModel
from flexdyn.model.stated_tolerances import kept_tolerances
from flexdyn.simulation.plant import check_model


def checked_model(model: Any) -> FlexibleJointModel:
    """The model with parameter errors and joint elasticities folded into its numbers, and without command delays.

    A delay is no law of this instant: it changes no torque at rest, and `command_delays` has it for responses. Currents
    follow their voltage at once, without inductance, and dry friction between two motors is left out.

    Raises:
        InputError: the argument is no model.
    """
    check_model(model)
    return _at_once(without(model.resolved(), _delays))


def _delays(effect: Effect) -> bool:
    return effect.stage == "actuator" and bool(effect.late_by)


def _at_once(model: FlexibleJointModel) -> FlexibleJointModel:
    """The model without inductance and without dry friction between motors; the same if it has none of them."""
    joints = {}
    for name, joint in model.joints.items():
        if joint.actuator is not None and joint.actuator.dc_motor.inductance > 0.0:
            joints[name] = {"actuator": joint.actuator.changed(inductance=0.0)}
    parts = (part for each in model.effects for part in each.parts())
    effects = [part for part in parts if not (isinstance(part, CouplingEffect) and part.stage == "dry")]
    if not joints and effects == list(model.effects):
        return model
    return model.replace(joints=joints, effects=effects)


def command_delays(model: FlexibleJointModel) -> Array:
    """Dead time between the commanded torque and the motor's (n,) [s]."""
    delays = np.zeros(model.n)
    for effect in model.resolved().effects:
        if isinstance(effect, JointEffect) and _delays(effect):
            delays[model.index(effect.joint)] += effect.lateness
    return delays


def dry_effects(model: FlexibleJointModel) -> Iterator[tuple[int, JointEffect]]:
    """The dry friction of joints that is not neutral, with each joint's index."""
    for effect in model.all_effects:
        if effect.stage == "dry" and not effect.is_neutral and isinstance(effect, JointEffect):
            yield model.index(effect.joint), effect


def without(model: FlexibleJointModel, leave_out: Callable[[Effect], bool]) -> FlexibleJointModel:
    """The model without some of its effects; the model itself if it has none of them."""
    kept = [i for i, effect in enumerate(model.all_effects) if not leave_out(effect)]
    if len(kept) == len(model.all_effects):
        return model
    effects, tolerance = [model.all_effects[i] for i in kept], kept_tolerances(model.tolerance, kept)
    return model.replace(effects=effects, tolerance=tolerance, urdf_dynamics="ignore")
