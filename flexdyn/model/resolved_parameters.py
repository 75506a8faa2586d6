"""Parameter errors and joint elasticities, applied to the numbers that they change."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Any

import numpy as np

from flexdyn.checks import check_known
from flexdyn.effects import Effect, JointEffect, ParameterError
from flexdyn.effects.model_error import effect_place, is_number_error
from flexdyn.errors import InputError, did_you_mean, placed
from flexdyn.model.given_number import UNKNOWN
from flexdyn.model.joint import JOINT_UNITS, Joint
from flexdyn.robot import Robot

OF_MOTOR = ("torque_constant", "resistance")
OF_URDF = {"urdf_damping": "damping", "urdf_friction": "friction"}
OF_LINK = {"link_mass": "mass", "link_com": "com", "link_inertia": "inertia"}


def units_of(robot: Robot, effect: Effect) -> dict[str, str]:
    """The units of an effect's parameters, which are other ones where its joint slides."""
    joint = getattr(effect, "joint", None)
    return effect.units(prismatic=joint is not None and robot.angle_unit(joint) == "m")


def folded(
    robot: Robot, joints: Mapping[str, Joint], effects: Sequence[Effect]
) -> tuple[Robot, dict[str, dict[str, Any]], list[Effect]]:
    """Apply parameter errors, then joint elasticities.

    Args:
        robot: as given.
        joints: its drives by name.
        effects: of the model; ``effects[i]`` counts in this list.

    Returns:
        The robot with the true numbers of links and <dynamics>, the true numbers of each drive, and the other effects
        with their true parameters.

    Raises:
        InputError: an unknown number, or a factor that makes the number invalid; its key is ``effects[i]``.
    """
    numbers = {name: joint.values() for name, joint in joints.items()}
    for name, joint in joints.items():
        numbers[name]["actuator"] = None if joint.actuator is None else joint.actuator.held(joint.gear_ratio)
    true = list(effects)
    of_links = factors_of(effects, OF_LINK)  # a link is changed once, as a new robot is made for it
    for i, error in enumerate(effects):
        if not is_number_error(error) or error.is_neutral:
            continue
        with placed(key=f"effects[{i}]"):
            if error.parameter in OF_LINK:
                factors = of_links.pop(error.of, {})
                robot = robot.with_link_scaled(error.of, **factors) if factors else robot
            elif error.of.startswith("effects["):
                _fold_effect(true, error)
            else:
                robot = _fold_joint(robot, numbers, error)
    for name, stiffness in elasticities(true):
        given = numbers[name]["stiffness"]
        numbers[name]["stiffness"] = stiffness + (given if math.isfinite(given) else 0.0)
    return robot, numbers, [effect for effect in true if not effect.in_numbers]


def elasticities(effects: Iterable[Effect]) -> Iterator[tuple[str, float]]:
    """Joint and stiffness [N m/rad or N/m] of every effect that makes a joint elastic."""
    for effect in effects:
        if isinstance(effect, JointEffect) and effect.makes_elastic and not effect.is_neutral:
            yield effect.joint, float(getattr(effect, effect.makes_elastic))


def factors_of(effects: Sequence[Effect], words: Mapping[str, str]) -> dict[str, dict[str, float]]:
    """What errors change numbers by, for every link or joint and its number; several on one number multiply.

    Args:
        effects: of which the errors are taken.
        words: the URDF's word for each number that counts.
    """
    found: dict[str, dict[str, float]] = {}
    for error in effects:
        if is_number_error(error) and error.parameter in words and not error.is_neutral:
            own, word = found.setdefault(error.of, {}), words[error.parameter]
            own[word] = own.get(word, 1.0) * error.factor
    return found


def _fold_effect(effects: list[Effect], error: ParameterError) -> None:
    """Replace the effect that an error is about by the same with its true parameter."""
    place = effect_place(error.of)
    if place is None or place >= len(effects):
        remedy = f"they count from 0 to {len(effects) - 1}"
        raise InputError("no such effect in the model", key="of", value=error.of, remedy=remedy)
    target = effects[place]
    if is_number_error(target):
        raise InputError("a parameter error has none itself", key="of", value=error.of)
    _check_parameter(error, [field.name for field in target.parameters()], target.name)
    entry = {key: value for key, value in target.to_dict().items() if key != "effect"}
    entry[error.parameter] *= error.factor
    effects[place] = type(target).from_dict(entry)


def _fold_joint(robot: Robot, numbers: dict[str, dict[str, Any]], error: ParameterError) -> Robot:
    """Apply an error to a number of a drive, its motor or the URDF's <dynamics>; return the robot."""
    if error.of not in numbers:
        remedy = did_you_mean(error.of, [*numbers, *robot.frame_names])
        raise InputError("no such joint, link or effect", key="of", value=error.of, remedy=remedy)
    _check_parameter(error, [*JOINT_UNITS, *OF_MOTOR, *OF_URDF, *OF_LINK], "a joint")
    own = numbers[error.of]
    if error.parameter in OF_MOTOR:
        if own["actuator"] is None:
            raise InputError("the joint has no actuator", key="parameter", value=error.parameter)
        own["actuator"] = own["actuator"].scaled(error.parameter, error.factor)
        return robot
    if error.parameter in OF_URDF:
        attribute = OF_URDF[error.parameter]
        values = np.array(getattr(robot, attribute))
        values[robot.joint_index(error.of)] *= error.factor
        changed: dict[str, Any] = {attribute: values, "source": None}
        return dataclasses.replace(robot, **changed)
    given = own[error.parameter]
    if given == UNKNOWN:
        raise InputError("the number is unknown: no factor can change it", key="parameter", value=error.parameter)
    if math.isinf(given):
        raise InputError("the joint is rigid: it has no stiffness", key="parameter", value=error.parameter)
    own[error.parameter] = given * error.factor
    return robot


def _check_parameter(error: ParameterError, known: Sequence[str], owner: str) -> None:
    check_known(error.parameter, known, f"{owner} has no such number", key="parameter", value=error.parameter)
