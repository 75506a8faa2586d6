"""First values of an unknown torque constant or resistance: volts are linear in torque and speed."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence

import numpy as np

from flexdyn.diagnose.constants import CERTAIN_SIGMAS
from flexdyn.diagnose.data.filters import Filters
from flexdyn.diagnose.data.measured import measured
from flexdyn.diagnose.decision.unknown_laws import without_unknown
from flexdyn.diagnose.decision.unknown_stiffnesses import taken_for_rigid
from flexdyn.diagnose.equations.equations import Equations
from flexdyn.diagnose.hypothesis.fitted import CORRELATION_BLOCK
from flexdyn.diagnose.hypothesis.regression import Regression
from flexdyn.diagnose.hypothesis.unknown_numbers import with_guesses
from flexdyn.errors import InputError
from flexdyn.model.flexible_joint_model import FlexibleJointModel
from flexdyn.model.given_number import UNKNOWN
from flexdyn.model.stated_tolerances import unknown_of_motors
from flexdyn.model.uncertain_parameters import UNKNOWN_TOLERANCE
from flexdyn.records import Recording
from flexdyn.simulation.electrical import with_asked_torque


def with_motors(model: FlexibleJointModel, recordings: Sequence[Recording]) -> FlexibleJointModel:
    """The model with a first value and a broad prior for every unknown torque constant or resistance.

    ``V = R/k tau + k omega``, k = gear_ratio torque_constant, is linear in R/k. The other number of the motor is known:
    k is no second unknown, as it would be told from viscous friction by nothing but volts. The prior's standard
    deviation is ten times the first value.

    Args:
        model: as given.
        recordings: that are fitted.

    Raises:
        InputError: both numbers of a motor are unknown, or the data do not tell the one that is.
    """
    unknown = unknown_of_motors(model.tolerance, model.joints)
    names = [name for name, _ in unknown]
    if not unknown or not isinstance(model.tolerance, Mapping):
        return model
    tolerance, joints = dict(model.tolerance), {}
    for name, number in unknown:
        key = f"joints.{name}.actuator.dc_motor.{number}"
        if names.count(name) > 1:
            remedy = "give one of the two numbers, with its tolerance: viscous friction looks like a change of both"
            raise InputError("torque constant and resistance are both unknown", key=key, value=UNKNOWN, remedy=remedy)
        joint, drive = model.joints[name], model.joints[name].actuator
        assert drive is not None  # noqa: S101 - see `unknown_of_motors`
        slope, std = _volts_per_torque(model, names, recordings, name)
        slope *= np.sign(joint.gear_ratio)
        if not slope > CERTAIN_SIGMAS * std:
            remedy = "give it with a tolerance, or record a motion that takes more torque"
            raise InputError("these data do not tell it", key=key, value=UNKNOWN, remedy=remedy)
        motor, ratio = drive.dc_motor, abs(joint.gear_ratio)
        of_resistance = number == "resistance"
        first = slope * ratio * motor.torque_constant if of_resistance else motor.resistance / (slope * ratio)
        joints[name] = {"actuator": drive.changed(**{number: first})}
        tolerance[key] = UNKNOWN_TOLERANCE
    return model.replace(joints=joints, tolerance=tolerance)


def _volts_per_torque(
    model: FlexibleJointModel, unknown: Sequence[str], recordings: Sequence[Recording], name: str
) -> tuple[float, float]:
    """R/k of a motor [V/(N m)] and its standard deviation, beside k and the volts that dry friction takes.

    Args:
        model: as given.
        unknown: joints whose motors have an unknown number.
        recordings: that are fitted.
        name: of the joint.
    """
    drives = {each: model.joints[each].actuator for each in unknown}
    in_volts = {each: dataclasses.replace(drive, torque_per_volt=1.0) for each, drive in drives.items() if drive}
    volts = model.replace(joints={each: {"actuator": drive} for each, drive in in_volts.items()})
    bare = volts.replace(joints={each: {"actuator": None} for each in unknown})
    bare = with_guesses(taken_for_rigid(without_unknown(bare), unknown))
    data = tuple(measured(bare, with_asked_torque(volts, each)) for each in recordings)
    equations, j = Equations(bare, data, Filters.of_rate(data[0].dt)), model.index(name)
    rows = equations.filters.rows
    columns = [
        rows(np.column_stack([along.tau[:, j], equations.needed(along, j), u := along.omega[:, j], np.sign(u)]))
        for along in equations.motions
    ]
    y, X = np.split(np.concatenate(columns), [1], axis=1)
    made = Regression(-y[:, 0], X, np.zeros(3), np.full(3, np.inf), len(y))
    block = max(1, round(CORRELATION_BLOCK / (equations.filters.every * data[0].dt)))
    return float(made.values[0]), float(np.sqrt(made.sandwich(block)[0, 0]))
