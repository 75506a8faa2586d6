"""Derivatives of the residuals with respect to the numbers of a model and of its effects."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from flexdyn.diagnose.abreast import SILENT, abreast
from flexdyn.diagnose.compliance import of_compliance
from flexdyn.diagnose.equations import Equations
from flexdyn.diagnose.made_up import NOT_PLAIN
from flexdyn.diagnose.measured import Measured
from flexdyn.diagnose.numbers import FileNumber
from flexdyn.diagnose.sensors import true_channel
from flexdyn.diagnose.terms import adds_up, own_torque
from flexdyn.effects import (
    ChannelLag,
    Effect,
    JointEffect,
    JointElasticity,
    Payload,
    SensorEffect,
    TorqueConstantError,
)
from flexdyn.errors import InputError
from flexdyn.model import FlexibleJointModel
from flexdyn.plant import LinkSide

Array = NDArray[np.float64]
STEP = 1e-3
"""Relative step of the differences."""


def of_numbers(equations: Equations, numbers: Sequence[FileNumber]) -> Array:
    """Derivatives of the residual (rows, numbers) by the factors of the file's numbers, where the model has them.

    Args:
        equations: of the model.
        numbers: of its file; those of links take one pass over the motion together.
    """
    found = np.empty((len(equations.residual), len(numbers)))
    links = [k for k, number in enumerate(numbers) if number.joint is None]
    if links:
        others = [LinkSide(_stepped(equations, numbers[k]).resolved()) for k in links]
        found[:, links] = equations.of_links(others) / STEP
    joints = [k for k in range(len(numbers)) if k not in links]

    def of_joint(k: int) -> Array:
        with SILENT():
            return _of_joint(equations, numbers[k])

    for k, slope in zip(joints, abreast(of_joint, joints), strict=True):
        found[:, k] = slope
    return found


def _stepped(equations: Equations, number: FileNumber) -> FlexibleJointModel:
    """The model with a number a little larger."""
    return equations.model.replace(effects=[*equations.model.effects, number.error(1.0 + STEP)])


def _of_joint(equations: Equations, number: FileNumber) -> Array:
    """Derivative of the residual (rows,) by the factor of a joint's number."""
    model, true = _stepped(equations, number), equations.true
    j, moved = true.index(str(number.joint)), model.resolved()
    if number.parameter == "stiffness":  # the scale of the link's equation moves with it
        return (equations.of(model).residual - equations.residual) / STEP
    if number.parameter == "rotor_inertia" and not true.elastic[j]:
        return equations.of_links([LinkSide(moved)])[:, 0] / STEP
    return (equations.of_joint(j, moved, moved.all_effects) - equations.own(j)) / STEP


def of_effect(equations: Equations, effect: Effect, scale: float = 1.0) -> Array:
    """Change of the residual (rows,) where the model has an effect more, over `scale`."""
    if isinstance(effect, SensorEffect):
        return _of_sensor(equations, effect) / scale
    if isinstance(effect, Payload):
        model = equations.true.replace(effects=[*equations.true.effects, effect])
        return equations.of_links([LinkSide(model)])[:, 0] / scale
    true, effect = equations.true, _on_joint(effect)
    j = true.index(effect.joint)
    if isinstance(effect, NOT_PLAIN) and equations.made_up[j]:
        there = equations.of(equations.model.replace(effects=[*equations.model.effects, effect]))
        return (there.residual - equations.residual) / scale
    if isinstance(effect, JointElasticity):  # to first order
        return of_compliance(equations, j) / (effect.stiffness * scale)
    if isinstance(effect, TorqueConstantError):
        return equations.of_torque(j, lambda along: ("motor", effect.gain * equations.needed(along, j))) / scale
    if adds_up(effect):
        return equations.of_torque(j, lambda along: own_torque(effect, true, along)) / scale
    with_it = equations.of_joint(j, true, [*true.all_effects, effect])
    return (with_it - equations.own(j)) / scale


def of_parameter(equations: Equations, effect: Effect, name: str, step: float) -> Array:
    """Derivative of the residual (rows,) by a parameter of an effect that the model holds.

    Args:
        equations: of the model with the effect.
        effect: that is there.
        name: of the parameter.
        step: of the difference, in the parameter's unit.
    """
    ahead = {name: getattr(effect, name) + step}
    if isinstance(effect, SensorEffect):
        return _of_sensor(equations, effect.replace(**ahead), effect) / step
    moved = effect.replace(**ahead)
    if isinstance(effect, Payload | TorqueConstantError):
        return (of_effect(equations, moved) - of_effect(equations, effect)) / step
    true = equations.true
    j = true.index(_on_joint(effect).joint)
    if isinstance(effect, JointElasticity) or (isinstance(effect, NOT_PLAIN) and equations.made_up[j]):
        # other rows and positions move with it
        effects = [moved if e == effect else e for e in equations.model.effects]
        return (equations.of(equations.model.replace(effects=effects)).residual - equations.residual) / step
    effects = [moved if e is effect or e == effect else e for e in true.all_effects]
    return (equations.of_joint(j, true, effects) - equations.own(j)) / step


def _on_joint(effect: Effect) -> JointEffect:
    """An effect with a torque along the motion.

    Raises:
        InputError: it has none.
    """
    if not isinstance(effect, JointEffect):
        raise InputError("the effect has no torque along a motion", key="effect", value=effect.name)
    return effect


def _of_sensor(equations: Equations, effect: SensorEffect, instead: SensorEffect | None = None) -> Array:
    """The measured channel holds what the sensor added: the true one is less by that.

    Args:
        equations: of the model.
        effect: of a sensor.
        instead: of another one of its kind; None: of none.
    """
    j = equations.true.index(effect.joint)

    def true(effect: SensorEffect, data: Measured, seen: Array) -> Array:
        if isinstance(effect, ChannelLag) and effect.signal == "tau":
            return np.asarray(np.interp(data.t + effect.delay, data.t, seen))
        return true_channel([effect], seen, data.dt)

    def error(data: Measured) -> Array:
        seen = data.channel(effect.signal)[:, j]
        return true(effect, data, seen) - (seen if instead is None else true(instead, data, seen))

    return equations.of_channel(effect.signal, j, error)
