"""Numbers of the model that moved within their tolerance: in their units, and as the page shows them."""

from __future__ import annotations

import math

from flexdyn.diagnose.report.measures import Calibration
from flexdyn.diagnose.report.suspects import Number
from flexdyn.effects.model_error import effect_place
from flexdyn.model.actuator import MOTOR_UNITS
from flexdyn.model.flexible_joint_model import FlexibleJointModel
from flexdyn.model.joint import JOINT_UNITS
from flexdyn.model.resolved_parameters import OF_MOTOR, units_of

FACTOR = "1"
"""Unit of a number of which only the factor is known."""


def estimate(model: FlexibleJointModel, entry: Calibration) -> Number:
    """A calibrated number in its unit.

    Args:
        model: corrected, see `number_as_given`.
        entry: its factor.
    """
    value, unit = number_as_given(model, entry.of, entry.parameter)
    return Number(entry.factor * value, entry.std * abs(value), unit)


def number_as_given(model: FlexibleJointModel, of: str, parameter: str) -> tuple[float, str]:
    """A number of the model file as given, with its unit; of a link's centre of mass and inertia the factor 1.

    These have several components, which the URDF has.

    Args:
        model: corrected; its joints and effects hold what was given, and parameter errors what became of it.
        of: joint, link or ``effects[i]``.
        parameter: its name.
    """
    value, unit = _number_of(model, of, parameter)
    return (value, unit) if math.isfinite(value) and value != 0.0 else (1.0, FACTOR)


def _number_of(model: FlexibleJointModel, of: str, parameter: str) -> tuple[float, str]:
    """Value and unit of a number of an effect, a drive or a link of the file; NaN for a factor on the URDF."""
    place = effect_place(of)
    if place is not None and place < len(model.effects):
        effect = model.effects[place]
        units = units_of(model.robot, effect)
        if parameter in units:
            return float(getattr(effect, parameter)), units[parameter]
    if of in model.joint_names and parameter in JOINT_UNITS:
        value = float(getattr(model.joints[of], parameter))
        return value, JOINT_UNITS[parameter][model.robot.angle_unit(of) == "m"]
    if parameter in OF_MOTOR and (motor := model.joints[of].actuator) is not None:
        return float(getattr(motor.dc_motor, parameter)), MOTOR_UNITS[parameter]
    if parameter == "link_mass":
        return model.robot.link_size(of)[0], "kg"
    if of in model.links and parameter == "link_inertia":
        return model.links[of].value, JOINT_UNITS["rotor_inertia"][0]
    return math.nan, FACTOR
