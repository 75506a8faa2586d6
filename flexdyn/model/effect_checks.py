"""Checks that effects fit the arm: the joints, frames and channels that they name exist and can have them."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

from flexdyn.checks import check_known
from flexdyn.effects import Effect, JointCoupling, JointEffect, JointElasticity, Payload, SensorEffect, effect_from_dict
from flexdyn.errors import InputError, placed
from flexdyn.model.joint import Joint
from flexdyn.robot import Robot
from flexdyn.robot.axes import joint_row

MEASURED = ("q", "v", "theta", "omega", "tau", "tau_applied", "tau_s")
"""Signals that a sensor effect can act on."""


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
    softened = {effect.joint for effect in effects if isinstance(effect, JointElasticity) and not effect.is_neutral}
    for i, effect in enumerate(effects):
        with placed(key=f"effects[{i}]"):
            _check(robot, joints, softened, effect)
    _check_pairs(effects)
    return tuple(effects)


def _check(robot: Robot, joints: Mapping[str, Joint], softened: set[str], effect: Effect) -> None:
    if isinstance(effect, Payload):
        frame = robot.frame(robot.tip if effect.frame is None else effect.frame)
        robot.tree.with_point_mass(frame, effect.mass)  # refuses one on the base
    elif isinstance(effect, SensorEffect):
        _check_channel(robot, effect)
    elif isinstance(effect, JointEffect) and joint_row(robot, effect.joint) is not None:
        _check_replaced(robot, effect)
    elif isinstance(effect, JointEffect):
        name = robot.joint_names[robot.joint_index(effect.joint)]
        if isinstance(effect, JointCoupling):
            _check_other(robot, effect)
        if isinstance(effect, JointElasticity):
            _check_softening(name, joints[name])
        elif not joints[name].elastic and name not in softened and _needs_spring(effect):
            remedy = f"give joints.{name} a finite stiffness, or the effect joint_elasticity"
            raise InputError(f"{effect.name} needs an elastic joint", key="joint", value=name, remedy=remedy)


def _check_replaced(robot: Robot, effect: JointEffect) -> None:
    """On a joint that axes replace, only torques on the link act on it alone."""
    if effect.stage == "link":
        return
    moved_by = " and ".join(axis for axis, entry in robot.axes.items() if effect.joint in entry)
    remedy = f"name an axis that moves it, {moved_by}; end_stop, parallel_spring and position_torque may name the joint"
    raise InputError(f"{effect.name} acts on axes", key="joint", value=effect.joint, remedy=remedy)


def _needs_spring(effect: JointEffect) -> bool:
    return effect.side == "transmission" or effect.takes_load


def _check_softening(name: str, joint: Joint) -> None:
    if joint.elastic:
        remedy = f"change joints.{name}.stiffness, or use hardening_spring"
        raise InputError("joint_elasticity needs a rigid joint", key="joint", value=name, remedy=remedy)
    if joint.rotor_inertia == 0 and not joint.given("rotor_inertia").is_unknown:
        remedy = f"give joints.{name}.rotor_inertia in kg m^2 on the motor side"
        raise InputError("joint_elasticity needs a rotor that has inertia", key="joint", value=name, remedy=remedy)


def _check_other(robot: Robot, effect: JointCoupling) -> None:
    try:
        robot.joint_index(effect.other)
    except InputError as error:
        raise InputError(error.problem, key="other", value=effect.other, remedy=error.remedy) from None


def _check_pairs(effects: list[Effect]) -> None:
    """Dry coupling is to one other motor only: the torques in a chain of motors that stick are not determined."""
    dry = [(i, each) for i, each in enumerate(effects) if isinstance(each, JointCoupling) and each.level > 0.0]
    for k, (i, second) in enumerate(dry):
        for _, first in dry[:k]:
            shared = {first.joint, first.other} & {second.joint, second.other}
            if shared and not first.matches(second):
                problem = f"{shared.pop()} has a dry coupling already"
                remedy = "a joint may have one with dry friction, or several with the same joint, other and ratio"
                raise InputError(problem, key=f"effects[{i}].level", value=second.level, remedy=remedy)


def _check_channel(robot: Robot, effect: SensorEffect) -> None:
    place = {"key": "channel", "value": effect.channel}
    check_known(effect.signal, MEASURED, "no such signal", **place)
    check_known(effect.joint, robot.joint_names, "the robot has no such joint", **place)
