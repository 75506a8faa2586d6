"""The numbers of a study that can vary: their paths, and how each is set in a run."""

from __future__ import annotations

from dataclasses import dataclass, field, fields
from typing import Any

from flexdyn.control.commands import PD
from flexdyn.control.setting_checks import per_joint
from flexdyn.model.flexible_joint_model import FlexibleJointModel
from flexdyn.model.joint import JOINT_UNITS
from flexdyn.model.resolved_parameters import units_of
from flexdyn.records import Recording
from flexdyn.records.signals.cut import with_channels
from flexdyn.records.units import unit_for
from flexdyn.robot import load_robot

FIRST_UNITS = {"q": "rad", "theta": "rad", "v": "rad/s", "omega": "rad/s"}
GAIN_UNITS = {"kp": "N m/rad", "kd": "N m s/rad"}


@dataclass
class Changes:
    """The changes of one run, set by the places of its numbers; for many runs it holds columns of numbers."""

    joints: dict[str, dict[str, Any]] = field(default_factory=dict)
    effects: dict[int, dict[str, Any]] = field(default_factory=dict)
    initial: dict[str, dict[str, Any]] = field(default_factory=dict)
    gravity: dict[int, Any] = field(default_factory=dict)
    lock: dict[str, Any] = field(default_factory=dict)
    gains: dict[str, dict[str, Any]] = field(default_factory=dict)
    rate: Any = None
    scale: Any = None

    def model(self, base: FlexibleJointModel) -> FlexibleJointModel:
        """The model with the changes; the same object if there are none.

        Raises:
            InputError: a number that it cannot have.
        """
        changes: dict[str, Any] = {}
        if self.joints:
            changes["joints"] = self.joints
        if self.effects:
            own = self.effects
            changes["effects"] = [each.replace(**own[i]) if i in own else each for i, each in enumerate(base.effects)]
        if self.initial:
            changes["initial"] = self.initial_of(base)
        if self.gravity:
            changes["gravity"] = [self.gravity.get(i, value) for i, value in enumerate(base.gravity)]
        if self.lock:
            robot = base.robot
            lock = {**robot.lock, **self.lock}
            source, folders = str(robot.source), robot.package_dirs
            changes["robot"] = load_robot(source, package_dirs=folders, lock=lock, name=robot.name)
        return base.replace(**changes) if changes else base

    def initial_of(self, base: FlexibleJointModel) -> dict[str, dict[str, Any]]:
        """The model's first state with the changes."""
        signals = dict.fromkeys([*base.initial, *self.initial])
        return {each: {**base.initial.get(each, {}), **self.initial.get(each, {})} for each in signals}

    def command(self, base: Any, joint_names: tuple[str, ...]) -> Any:
        """The command with the changes; the same object if there are none.

        Args:
            base: the command of the study.
            joint_names: of the arm.
        """
        if isinstance(base, Recording) and self.scale is not None:
            torques = {name: column for name, column in base.channels.items() if name.startswith("tau.")}
            return with_channels(base, {name: column * self.scale for name, column in torques.items()})
        if isinstance(base, PD) and (self.gains or self.rate is not None):
            settings = {each.name: getattr(base, each.name) for each in fields(base)}
            for gain, values in self.gains.items():
                known = dict(zip(joint_names, per_joint(f"pd.{gain}", settings[gain], joint_names), strict=True))
                settings[gain] = {joint: float(value) for joint, value in known.items()} | values
            settings["rate"] = base.rate if self.rate is None else self.rate
            return PD(**settings)
        return base


@dataclass(frozen=True)
class NumberPlace:
    """The place of one number.

    Attributes:
        unit: of the number.
        group: the attribute of `Changes` that has it.
        outer: keys in that group; none: the attribute is the number itself.
        inner: keys below each of them, such as joint -> number; none: the number stands under the outer key.
    """

    unit: str
    group: str
    outer: tuple[Any, ...] = ()
    inner: tuple[str, ...] = ()

    def put(self, changes: Changes, value: Any) -> None:
        """Write the number into the changes of a run."""
        if not self.outer:
            setattr(changes, self.group, value)
        for name in self.outer:
            group = getattr(changes, self.group)
            group[name] = group.get(name, {}) | dict.fromkeys(self.inner, value) if self.inner else value


def places(model: FlexibleJointModel, command: Any) -> dict[str, NumberPlace]:
    """Every number that can vary, by its path; those of all joints (``*``) come before those of one.

    Args:
        model: the arm.
        command: a recording, `PD` or None.
    """
    kinds = dict(zip(model.joint_names, model.robot.kinds, strict=True))
    groups = [("*", tuple(kinds), set(kinds.values()) == {"prismatic"})]
    groups += [(joint, (joint,), kind == "prismatic") for joint, kind in kinds.items()]
    found: dict[str, NumberPlace] = {}
    for name, joints, slides in groups:
        for number, units in JOINT_UNITS.items():
            found[f"joints.{name}.{number}"] = NumberPlace(units[slides], "joints", joints, (number,))
        for signal, unit in FIRST_UNITS.items():
            unit = unit_for(unit, prismatic=slides)
            found[f"initial.{signal}.{name}"] = NumberPlace(unit, "initial", (signal,), joints)
    for i, effect in enumerate(model.effects):
        for parameter, unit in units_of(model.robot, effect).items():
            found[f"effects[{i}].{parameter}"] = NumberPlace(unit, "effects", (i,), (parameter,))
    for i in range(3):
        found[f"robot.gravity[{i}]"] = NumberPlace("m/s^2", "gravity", (i,))
    for joint in model.robot.lock:
        found[f"robot.lock.{joint}"] = NumberPlace("rad or m", "lock", (joint,))
    return found | _command_places(command, groups)


def _command_places(command: Any, groups: list[tuple[str, tuple[str, ...], bool]]) -> dict[str, NumberPlace]:
    """Numbers of a command that a study can vary, by their paths."""
    if isinstance(command, Recording):
        return {"command.scale": NumberPlace("1", "scale")}
    if not isinstance(command, PD):
        return {}
    found = {"command.pd.rate": NumberPlace("Hz", "rate")}
    for gain, unit in GAIN_UNITS.items():
        for name, joints, slides in groups:
            path = f"command.pd.{gain}" if name == "*" else f"command.pd.{gain}.{name}"
            found[path] = NumberPlace(unit_for(unit, prismatic=slides), "gains", (gain,), joints)
    return found
