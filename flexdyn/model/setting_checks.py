"""Checks of a model's settings and effects against its robot: every mistake is an InputError that names its key."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from types import MappingProxyType
from typing import Any

import numpy as np

from flexdyn.checks import as_number, check_known, number
from flexdyn.control.commands import PD
from flexdyn.control.points import command_of
from flexdyn.control.samples import Samples
from flexdyn.control.setting_checks import per_joint
from flexdyn.effects import CouplingEffect, Effect, InertiaEffect, JointEffect, SensorEffect, effect_from_dict
from flexdyn.effects.catalogue import names_where
from flexdyn.errors import InputError, placed, retold
from flexdyn.io.locked import frozen
from flexdyn.model.given_number import UNKNOWN
from flexdyn.model.joint import NUMBERS, Joint
from flexdyn.model.resolved_parameters import elasticities
from flexdyn.robot import Robot
from flexdyn.robot.axes import joint_row

INITIAL_KEYS = ("q", "v", "theta", "omega")
MEASURED = ("q", "v", "theta", "omega", "tau", "tau_applied", "tau_s")
"""Signals that a sensor effect can act on."""


def one_of(key: str, value: str, allowed: tuple[str, ...]) -> str:
    """Check that a setting is one of the allowed words."""
    check_known(value, allowed, "no such choice", key=key, value=value, remedy=f"it is {' or '.join(allowed)}")
    return value


def gravity_checked(value: Any) -> tuple[float, float, float]:
    """Check for three finite numbers [m/s^2].

    Raises:
        InputError: it is something else.
    """
    listed = list(value) if isinstance(value, Sequence | np.ndarray) and not isinstance(value, str) else []
    numbers = [as_number(component) for component in listed]
    if len(numbers) != 3 or not all(map(math.isfinite, numbers)):
        raise InputError("three numbers are needed", key="robot.gravity", value=value, remedy="write [0.0, 0.0, -9.81]")
    return numbers[0], numbers[1], numbers[2]


def initial_checked(entries: Mapping[str, Any], names: tuple[str, ...]) -> Mapping[str, Mapping[str, float]]:
    """First positions and velocities, by signal and joint, read-only.

    Args:
        entries: as given.
        names: of the joints.

    Raises:
        InputError: an unknown signal or joint, or a value that is no finite number.
    """
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
    """One relative tolerance, or several by the dotted path of the number, read-only; infinite: it is unknown."""
    entries = value if isinstance(value, Mapping) else {"*": value}
    found = {}
    for path, entry in entries.items():
        key = "tolerance" if path == "*" else f"tolerance.{path}"
        problem, remedy = "a number of at least 0 is needed", "0.05 means 5 %, 1 sigma"
        found[str(path)] = number(key, entry, problem, least=0.0, infinite=path != "*", remedy=remedy)
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
        InputError: an unknown path; the message names the most similar one. An infinite tolerance: a file says
            ``unknown`` in place of the number.
    """
    if not isinstance(tolerance, Mapping):
        return
    numbers = (*NUMBERS, *(f"actuator.dc_motor.{number}" for number in ("torque_constant", "resistance")))
    known = ["*", *(f"joints.{joint}.{number}" for joint in ("*", *joints) for number in numbers)]
    known += [f"effects[{i}].{field.name}" for i, effect in enumerate(effects) for field in effect.parameters()]
    known += [f"links.{link}.{number}" for link in links for number in ("mass", "com", "inertia")]
    for path, share in tolerance.items():
        check_known(str(path), known, "no such number in the model", key=f"tolerance.{path}")
        if share == math.inf:
            remedy = f"write {UNKNOWN} for the number itself"
            raise InputError("a finite number is needed", key=f"tolerance.{path}", value=share, remedy=remedy)


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


def fitted(robot: Robot, joints: Mapping[str, Joint], entries: Iterable[Any]) -> tuple[Effect, ...]:
    """Check each effect against the arm and against the other effects, and return them.

    Args:
        robot: whose joints and frames they name.
        joints: the drives by name.
        entries: effects, or entries of a model file.

    Raises:
        InputError: an effect does not fit; its key is ``effects[i]``.
    """
    effects: list[Effect] = []
    for i, entry in enumerate(entries):
        with placed(key=f"effects[{i}]"):
            effects.append(entry if isinstance(entry, Effect) else effect_from_dict(entry))
    softened = {joint for joint, _ in elasticities(effects)}
    for i, effect in enumerate(effects):
        with placed(key=f"effects[{i}]"):
            _check(robot, joints, softened, effect)
    for i, effect in enumerate(effects):
        with placed(key=f"effects[{i}]"):
            effect.check_beside(effects[:i])
    return tuple(effects)


def _check(robot: Robot, joints: Mapping[str, Joint], softened: set[str], effect: Effect) -> None:
    """Refuse an effect where it cannot act."""
    if isinstance(effect, InertiaEffect):
        frame, mass = effect.point_mass
        robot.tree.with_point_mass(robot.frame(robot.tip if frame is None else frame), mass)  # refuses one on the base
    elif isinstance(effect, SensorEffect):
        _check_channel(robot, effect)
    elif isinstance(effect, JointEffect) and joint_row(robot, effect.joint) is not None:
        _check_replaced(robot, effect)
    elif isinstance(effect, JointEffect):
        name = robot.joint_names[robot.joint_index(effect.joint)]
        if isinstance(effect, CouplingEffect):
            with retold(key="other", value=effect.partner):
                robot.joint_index(effect.partner)
        if effect.makes_elastic:
            _check_softening(effect, joints[name])
        elif not joints[name].elastic and name not in softened and (effect.side == "transmission" or effect.takes_load):
            elastic = names_where(lambda kind: kind.makes_elastic)
            remedy = f"give joints.{name} a finite stiffness, or the effect {elastic}"
            raise InputError(f"{effect.name} needs an elastic joint", key="joint", value=name, remedy=remedy)


def _check_replaced(robot: Robot, effect: JointEffect) -> None:
    """On a joint that axes replace, only torques on the link act on it alone."""
    if effect.stage == "link":
        return
    moved_by = " and ".join(axis for axis, entry in robot.axes.items() if effect.joint in entry)
    free = names_where(lambda kind: kind.stage == "link")
    remedy = f"name an axis that moves it, {moved_by}; {free} may name the joint"
    raise InputError(f"{effect.name} acts on axes", key="joint", value=effect.joint, remedy=remedy)


def _check_softening(effect: JointEffect, joint: Joint) -> None:
    """Refuse an elasticity where the joint has one already, or no rotor that could move."""
    name = effect.joint
    if joint.elastic:
        remedy = f"change joints.{name}.stiffness"
        raise InputError(f"{effect.name} needs a rigid joint", key="joint", value=name, remedy=remedy)
    if joint.rotor_inertia == 0 and not joint.given("rotor_inertia").is_unknown:
        remedy = f"give joints.{name}.rotor_inertia in kg m^2 on the motor side"
        raise InputError(f"{effect.name} needs a rotor that has inertia", key="joint", value=name, remedy=remedy)


def _check_channel(robot: Robot, effect: SensorEffect) -> None:
    place = {"key": "channel", "value": effect.channel}
    check_known(effect.signal, MEASURED, "no such signal", **place)
    check_known(effect.joint, robot.joint_names, "the robot has no such joint", **place)
