"""Checks of a model's settings: every mistake is an InputError that names its key."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from types import MappingProxyType
from typing import Any

import numpy as np

from flexdyn.checks import as_number, check_known, number
from flexdyn.control.commands import PD, Samples, per_joint
from flexdyn.control.points import command_of
from flexdyn.effects import Effect
from flexdyn.errors import InputError, placed
from flexdyn.io.locked import frozen
from flexdyn.model.joint import NUMBERS

INITIAL_KEYS = ("q", "v", "theta", "omega")


def one_of(key: str, value: str, allowed: tuple[str, ...]) -> str:
    """Check that a setting is one of the allowed words."""
    if value not in allowed:
        raise InputError("no such choice", key=key, value=value, remedy=f"it is {' or '.join(allowed)}")
    return value


def gravity_checked(value: Any) -> tuple[float, float, float]:
    """Check for three finite numbers [m/s^2]."""
    listed = list(value) if isinstance(value, Sequence | np.ndarray) and not isinstance(value, str) else []
    numbers = [as_number(component) for component in listed]
    if len(numbers) != 3 or not all(map(math.isfinite, numbers)):
        raise InputError("three numbers are needed", key="robot.gravity", value=value, remedy="write [0.0, 0.0, -9.81]")
    return numbers[0], numbers[1], numbers[2]


def initial_checked(entries: Mapping[str, Any], names: tuple[str, ...]) -> Mapping[str, Mapping[str, float]]:
    """First positions and velocities, by signal and joint, read-only."""
    checked = {}
    if not isinstance(entries, Mapping):
        raise InputError("a mapping is needed", key="initial", value=entries, remedy="write {q: {JOINT: value}}")
    for signal, values in entries.items():
        check_known(signal, INITIAL_KEYS, "no such signal", key=f"initial.{signal}")
        if not isinstance(values, Mapping):
            raise InputError("a mapping by joint is needed", key=f"initial.{signal}", value=values)
        for joint, value in values.items():
            place = f"initial.{signal}.{joint}"
            check_known(joint, names, "the robot has no such joint", key=place)
            number(place, value)
        checked[signal] = MappingProxyType({joint: float(value) for joint, value in values.items()})
    return MappingProxyType(checked)


def tolerance_checked(value: Any) -> float | Mapping[str, float]:
    """One relative tolerance, or several by the dotted path of the number, read-only."""
    entries = value if isinstance(value, Mapping) else {"*": value}
    found = {}
    for path, entry in entries.items():
        key = "tolerance" if path == "*" else f"tolerance.{path}"
        problem, remedy = "a number of at least 0 is needed", "0.05 means 5 %, 1 sigma"
        found[str(path)] = number(key, entry, problem, least=0.0, remedy=remedy)
    return MappingProxyType(found) if isinstance(value, Mapping) else found["*"]


def check_tolerance_paths(
    tolerance: Any, joints: Sequence[str], links: Sequence[str], effects: Sequence[Effect]
) -> None:
    """Refuse a tolerance of a number that does not exist.

    Args:
        tolerance: of a model file.
        joints: names of the robot's joints.
        links: names of its links.
        effects: of the file.

    Raises:
        InputError: an unknown path; the message names the most similar one.
    """
    if not isinstance(tolerance, Mapping):
        return
    numbers = (*NUMBERS, *(f"actuator.dc_motor.{number}" for number in ("torque_constant", "resistance")))
    known = ["*", *(f"joints.{joint}.{number}" for joint in ("*", *joints) for number in numbers)]
    known += [f"effects[{i}].{field.name}" for i, effect in enumerate(effects) for field in effect.parameters()]
    known += [f"links.{link}.{number}" for link in links for number in ("mass", "com", "inertia")]
    for path in tolerance:
        check_known(str(path), known, "no such number in the model", key=f"tolerance.{path}")


def command_checked(command: Any, joint_names: Sequence[str]) -> Mapping[str, Any] | None:
    """Check a command of points against the robot, and return a read-only copy.

    Raises:
        InputError: a key, joint or point that does not fit.
    """
    if command is None:
        return None
    with placed(key="command"):
        if not isinstance(command, Mapping):
            raise InputError("a mapping with pd or torques is needed", value=command)
        made = command_of(command)
        for samples in (made,) if isinstance(made, Samples) else (made.reference, made.feedforward):
            if samples is not None:
                samples.columns(joint_names)
        if isinstance(made, PD):
            for gain in ("kp", "kd"):
                per_joint(f"pd.{gain}", getattr(made, gain), joint_names)
    locked: Mapping[str, Any] = frozen(command)
    return locked
