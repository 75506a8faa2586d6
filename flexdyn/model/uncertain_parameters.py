"""The numbers of a model file that may be wrong, each with its tolerance."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace

import numpy as np

from flexdyn.effects import Effect, ParameterError
from flexdyn.errors import InputError
from flexdyn.model.flexible_joint_model import FlexibleJointModel
from flexdyn.model.given_number import GivenNumber, robot_with_links
from flexdyn.model.resolved_parameters import OF_LINK, OF_MOTOR
from flexdyn.model.stated_tolerances import known_tolerances

UNCERTAIN_OF_JOINT = ("rotor_inertia", "stiffness", "damping")
DEFAULT_TOLERANCE = 0.05
UNKNOWN_TOLERANCE = 10.0
"""From this relative tolerance on a number counts as unknown [1]."""
INERTIA_ROUNDING = 1e-12
"""Relative change of inertias that is due to rounding [1]."""


@dataclass(frozen=True)
class FileNumber:
    """One number of a model file.

    Attributes:
        of: joint, link or ``effects[i]`` that it belongs to.
        parameter: its name, as `ParameterError` takes it.
        value: as given.
        tolerance: how well it is known, relative, 1 sigma; an absolute tolerance is divided by the value.
        joint: the joint that it belongs to; None for a number of a link.
        signed: whether it may have either sign, so that its factor may be negative.
        trusted: whether its tolerance is taken for right. Where a motor's other number was unknown, a change of both is
            the same as viscous friction.
    """

    of: str
    parameter: str
    value: float
    tolerance: float
    joint: str | None
    signed: bool = False
    trusted: bool = False

    @property
    def is_open(self) -> bool:
        """Whether it was unknown: its tolerance is much larger than the value from which a diagnosis starts."""
        return self.tolerance >= UNKNOWN_TOLERANCE

    def error(self, factor: float) -> ParameterError:
        """The effect ``true = factor*given`` for this number."""
        return ParameterError(self.of, parameter=self.parameter, factor=factor)


def file_numbers(model: FlexibleJointModel) -> tuple[FileNumber, ...]:
    """Every number of the model that has an influence and could be wrong.

    The gear ratio is left out: all signals are reflected, so it changes only the reflected rotor inertia N^2 J.
    """
    found = [*_of_joints(model), *_of_links(model), *_of_effects(model)]
    return tuple(number for number in found if number.value != 0.0 and math.isfinite(number.value))


def with_factors(
    model: FlexibleJointModel, factors: Mapping[FileNumber, float], found: Iterable[Effect] = ()
) -> FlexibleJointModel:
    """The model with changed numbers and additional effects."""
    errors = [number.error(factor) for number, factor in factors.items() if factor != 1.0]
    return model.replace(effects=[*model.effects, *errors, *found])


def _of_joints(model: FlexibleJointModel) -> Iterable[FileNumber]:
    """Numbers of drives and their motors."""
    for name, joint in model.joints.items():
        for parameter in UNCERTAIN_OF_JOINT:
            path = f"joints.{name}.{parameter}"
            tolerance = _tolerance(model, path, f"joints.*.{parameter}")
            given = joint.given(parameter)
            yield FileNumber(name, parameter, given.value, _share_or(given, tolerance), name)
        motor = None if joint.actuator is None else joint.actuator.dc_motor
        found = []
        for parameter in () if motor is None else OF_MOTOR:
            tolerance = _tolerance(model, *(f"joints.{each}.actuator.dc_motor.{parameter}" for each in (name, "*")))
            found.append(FileNumber(name, parameter, getattr(motor, parameter), tolerance, name))
        open_ = any(each.is_open for each in found)
        yield from (replace(each, trusted=open_ and not each.is_open) for each in found)


def _of_links(model: FlexibleJointModel) -> Iterable[FileNumber]:
    """Those that change the torques of the arm: not the centre of mass of a link if it is at the link's origin."""
    robot = robot_with_links(model.robot, model.links)
    own = robot.tree.inertial_parameters
    for frame in robot.frame_names:
        for parameter, word in OF_LINK.items():
            try:
                other = robot.with_link_scaled(frame, **{word: 2.0})
            except InputError:
                break
            if np.abs(other.tree.inertial_parameters - own).max() > INERTIA_ROUNDING * np.abs(own).max():
                tolerance = _tolerance(model, f"links.{frame}.{word}")
                if parameter == "link_inertia" and frame in model.links:
                    tolerance = _share_or(model.links[frame], tolerance)
                yield FileNumber(frame, parameter, 1.0, tolerance, None)


def _of_effects(model: FlexibleJointModel) -> Iterable[FileNumber]:
    """Numbers of effects that their classes declare to be uncertain."""
    for i, effect in enumerate(model.effects):
        for name in effect.uncertain():
            place = f"effects[{i}]"
            tolerance = _tolerance(model, f"{place}.{name}")
            signed = effect.declared(name)["lower"] < 0.0
            yield FileNumber(place, name, getattr(effect, name), tolerance, getattr(effect, "joint", None), signed)


def _share_or(given: GivenNumber, otherwise: float) -> float:
    """Tolerance of a number relative to its value."""
    return otherwise if given.tolerance is None or given.value == 0.0 else given.tolerance / abs(given.value)


def _tolerance(model: FlexibleJointModel, *paths: str) -> float:
    """Tolerance of a number: by its own path, else the default, as for one that was unknown and is now given."""
    if not isinstance(model.tolerance, Mapping):
        return float(model.tolerance)
    known = known_tolerances(model.tolerance)
    return float(next((known[path] for path in (*paths, "*") if path in known), DEFAULT_TOLERANCE))
