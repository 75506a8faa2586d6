"""Derivatives of the residuals with respect to the numbers of a model file."""

from __future__ import annotations

import numpy as np

from flexdyn.arrays import Array
from flexdyn.diagnose.equations.columns import is_loaded, of_change, on_joint, stands_alone
from flexdyn.diagnose.equations.equations import Equations, Torques
from flexdyn.diagnose.equations.motion import SmoothedMotion
from flexdyn.diagnose.equations.terms import spreads
from flexdyn.diagnose.lazy import kept
from flexdyn.diagnose.parallel import SILENT, in_parallel
from flexdyn.effects import JointEffect
from flexdyn.effects.model_error import effect_place
from flexdyn.model.flexible_joint_model import FlexibleJointModel
from flexdyn.model.resolved_parameters import OF_LINK, OF_MOTOR
from flexdyn.model.uncertain_parameters import FileNumber
from flexdyn.simulation.link_side import LinkSide

RELATIVE_NUMBER_STEP = 1e-5
"""Relative step of the differences."""


@kept
def of_numbers(equations: Equations, numbers: tuple[FileNumber, ...]) -> Array:
    """Derivatives of the residual (rows, numbers) by the factors of the file's numbers; the equations keep them.

    Args:
        equations: of the model.
        numbers: of its file; those of all links need one pass over the motion.
    """
    found = np.empty((len(equations.residual), len(numbers)))
    links = [k for k, number in enumerate(numbers) if number.joint is None]
    links = [] if equations.replayed.any() else links  # links that are simulated move otherwise
    if links:
        heavier = [LinkSide(_heavier(equations.true, numbers[k])) for k in links]
        found[:, links] = equations.of_links(heavier) / RELATIVE_NUMBER_STEP
    joints = [k for k in range(len(numbers)) if k not in links]

    def of_joint(k: int) -> Array:
        """Derivative by a number of a joint."""
        with SILENT():
            return _of_joint(equations, numbers[k])

    for k, slope in zip(joints, in_parallel(of_joint, joints), strict=True):
        found[:, k] = slope
    return found


def _heavier(true: FlexibleJointModel, number: FileNumber) -> FlexibleJointModel:
    """A resolved model with a slightly larger number of a link."""
    return true.replace(
        robot=true.robot.with_link_scaled(number.of, **{OF_LINK[number.parameter]: 1.0 + RELATIVE_NUMBER_STEP})
    )


def _of_joint(equations: Equations, number: FileNumber) -> Array:
    """Derivative of the residual (rows,) by the factor of a joint's number."""
    true, effect, name = equations.true, _true_effect(equations, number), number.parameter
    spread = effect is not None and spreads(effect, true)
    if effect is not None and not spread and stands_alone(equations, effect):
        more = effect.replace(**{name: (1.0 + RELATIVE_NUMBER_STEP) * getattr(effect, name)})
        return of_change(equations, effect, more) / RELATIVE_NUMBER_STEP
    effects = [*equations.model.effects, number.error(1.0 + RELATIVE_NUMBER_STEP)]
    j = None if number.joint is None or spread else true.index(number.joint)
    # The scale of the link's or motor's equation changes with a stiffness, and with a motor's numbers.
    if j is None or name in ("stiffness", *OF_MOTOR) or (equations.replayed[j] and name != "rotor_inertia"):
        return equations.change(effects) / RELATIVE_NUMBER_STEP
    if number.joint == number.of and not (equations.computed[j] or is_loaded(equations, j)) and true.elastic[j]:
        if name == "rotor_inertia":
            return equations.of_torque(j, lambda along: ("motor", -true.rotor_inertia[j] * along.alpha[:, j]))
        if name == "damping":
            return equations.of_terms(j, lambda along: _damper(true, along, j))
    moved = equations.model.replace(effects=effects).resolved()
    if name == "rotor_inertia" and not true.elastic[j]:
        return equations.of_links([LinkSide(moved)])[:, 0] / RELATIVE_NUMBER_STEP
    return (equations.of_joint(j, moved, moved.all_effects) - equations.own(j)) / RELATIVE_NUMBER_STEP


def _damper(true: FlexibleJointModel, along: SmoothedMotion, j: int) -> Torques:
    """The torques of the damper of an elastic joint."""
    torque = true.damping[j] * along.ddelta[:, j]
    return -torque, torque, -torque


def _true_effect(equations: Equations, number: FileNumber) -> JointEffect | None:
    """The effect of the resolved model to which a number of the file belongs; None: it belongs to a joint."""
    place = effect_place(number.of)
    if place is None:
        return None
    given, true = equations.model, equations.true
    folded = 0 if given is true else sum(e.in_numbers for e in given.effects[:place])
    return on_joint(true.effects[place - folded])
