"""Derivatives of the residuals with respect to the numbers of a model file."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from flexdyn.arrays import Array
from flexdyn.diagnose.abreast import SILENT, abreast
from flexdyn.diagnose.equations.columns import is_loaded, of_change, on_joint, stands_alone
from flexdyn.diagnose.equations.equations import Equations
from flexdyn.diagnose.equations.terms import spreads
from flexdyn.effects import JointEffect
from flexdyn.effects.model_error import effect_place
from flexdyn.model.flexible_joint_model import FlexibleJointModel
from flexdyn.model.resolved_parameters import OF_LINK, OF_MOTOR
from flexdyn.model.uncertain_parameters import FileNumber
from flexdyn.simulation.plant import LinkSide

RELATIVE_NUMBER_STEP = 1e-3
"""Relative step of the differences."""


def of_numbers(equations: Equations, numbers: Sequence[FileNumber]) -> Array:
    """Derivatives of the residual (rows, numbers) by the factors of the file's numbers.

    Args:
        equations: of the model.
        numbers: of its file; those of all links need one pass over the motion.
    """
    found = np.empty((len(equations.residual), len(numbers)))
    links = [k for k, number in enumerate(numbers) if number.joint is None]
    if equations.replayed.any():  # links that are simulated move otherwise
        links = []
    if links:
        heavier = [LinkSide(_heavier(equations.true, numbers[k])) for k in links]
        found[:, links] = equations.of_links(heavier) / RELATIVE_NUMBER_STEP
    joints = [k for k in range(len(numbers)) if k not in links]

    def of_joint(k: int) -> Array:
        with SILENT():
            return _of_joint(equations, numbers[k])

    for k, slope in zip(joints, abreast(of_joint, joints), strict=True):
        found[:, k] = slope
    return found


def _heavier(true: FlexibleJointModel, number: FileNumber) -> FlexibleJointModel:
    """A resolved model with a slightly larger number of a link."""
    return true.replace(
        robot=true.robot.with_link_scaled(number.of, **{OF_LINK[number.parameter]: 1.0 + RELATIVE_NUMBER_STEP})
    )


def _of_joint(equations: Equations, number: FileNumber) -> Array:
    """Derivative of the residual (rows,) by the factor of a joint's number."""
    true = equations.true
    effect = _true_effect(equations, number)
    if number.joint is None or (effect is not None and spreads(effect, true)):
        return _of_all(equations, number)
    j = true.index(str(number.joint))
    if effect is not None and stands_alone(equations, effect):
        more = (1.0 + RELATIVE_NUMBER_STEP) * getattr(effect, number.parameter)
        return of_change(equations, effect, effect.replace(**{number.parameter: more})) / RELATIVE_NUMBER_STEP
    if equations.replayed[j] and number.parameter != "rotor_inertia" and number.parameter not in OF_MOTOR:
        return _of_all(equations, number)
    if number.joint == number.of and not (equations.made_up[j] or is_loaded(equations, j)) and true.elastic[j]:
        if number.parameter == "rotor_inertia":
            return equations.of_torque(j, lambda along: ("motor", -true.rotor_inertia[j] * along.alpha[:, j]))
        if number.parameter == "damping":
            return equations.of_damper(j)
    # The scale of the link's or motor's equation changes with it.
    if number.parameter in ("stiffness", *OF_MOTOR):
        return _of_all(equations, number)
    moved = _moved(equations, number).resolved()
    if number.parameter == "rotor_inertia" and not true.elastic[j]:
        return equations.of_links([LinkSide(moved)])[:, 0] / RELATIVE_NUMBER_STEP
    return (equations.of_joint(j, moved, moved.all_effects) - equations.own(j)) / RELATIVE_NUMBER_STEP


def _of_all(equations: Equations, number: FileNumber) -> Array:
    """Derivative of the residual (rows,) by the factor of a number, with all equations computed again."""
    return (equations.of(_moved(equations, number)).residual - equations.residual) / RELATIVE_NUMBER_STEP


def _moved(equations: Equations, number: FileNumber) -> FlexibleJointModel:
    """The model with a slightly larger number."""
    return equations.model.replace(effects=[*equations.model.effects, number.error(1.0 + RELATIVE_NUMBER_STEP)])


def _true_effect(equations: Equations, number: FileNumber) -> JointEffect | None:
    """The effect of the resolved model to which a number of the file belongs; None: it belongs to a joint."""
    place = effect_place(number.of)
    if place is None:
        return None
    given, true = equations.model, equations.true
    folded = 0 if given is true else sum(e.in_numbers for e in given.effects[:place])
    return on_joint(true.effects[place - folded])
