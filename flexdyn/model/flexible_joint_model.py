"""FlexibleJointModel: a robot, its drives and the effects on them, as plain immutable data."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from functools import cached_property, partial
from types import MappingProxyType
from typing import Any

import numpy as np

from flexdyn.arrays import Array, Flags, Indices
from flexdyn.effects import Effect
from flexdyn.effects.motor import MotorLaw
from flexdyn.errors import InputError, visible
from flexdyn.io.locked import lock, plain
from flexdyn.io.notebook import Public
from flexdyn.model.actuator import MOTOR_UNITS
from flexdyn.model.given_number import GivenNumber, link_inertias, links_entry, refusal, robot_with_links, unknown_links
from flexdyn.model.joint import JOINT_UNITS, Joint, resolve_joints
from flexdyn.model.resolved_parameters import elasticities, folded, units_of
from flexdyn.model.setting_checks import (
    command_checked,
    fitted,
    gravity_checked,
    initial_checked,
    one_of,
    tolerance_checked,
)
from flexdyn.model.stated_tolerances import (
    kept_tolerances,
    unknown_masses,
    unknown_of_motors,
    unknown_parameters,
    with_stated_tolerances,
)
from flexdyn.model.summary import as_card
from flexdyn.model.urdf_dynamics import urdf_effects
from flexdyn.robot import Robot

EARTH = (0.0, 0.0, -9.81)


class FlexibleJointModel(Public):
    """An arm with elastic joints.

    The equations of motion, every motor-side quantity reflected to the link side of its gear::

        M(q) a + h(q, v) + f_link = tau_s + tau_ext          link side   (paper, eq. 3)
        J alpha         + f_motor = tau_applied - tau_s      rotor side  (paper, eq. 4)
        tau_s = K (theta - q) + D (omega - v) + ...          transmission

    M and h (Coriolis, centrifugal, gravity) come from Pinocchio. A joint of infinite stiffness is rigid: theta = q,
    and its J is added to M. The friction torques f_link, f_motor and all other torques are the model's effects.

    Args:
        robot: from `load_robot`.
        joints: joint name -> `Joint` or mapping of its numbers; ``"*"`` applies to all joints that are not named. A
            number may be ``"unknown"`` or have an absolute tolerance, see `Joint`; in an actuator's mapping so may
            torque constant and resistance.
        effects: any number of them; several of one kind add up. In a mapping, a number may have an absolute tolerance;
            a size that is 0 or more, such as a level of friction, may be ``"unknown"``.
        initial: ``{"q": {"elbow": 1.57}}``; also v, theta, omega [rad, rad/s]. Default 0, theta = q, omega = v.
        tolerance: how well the numbers are known, relative, 1 sigma; a mapping sets it per number by its dotted path
            (``{"*": 0.05, "joints.elbow.stiffness": 0.2}``).
        links: link name -> ``{"inertia": moment}`` [kg m^2], the same about every axis through the centre of mass. It
            replaces the URDF's value, which is often 0; it may be ``"unknown"`` or have an absolute tolerance.
            ``{"mass": {"tolerance": 0.1}}`` [kg] is the absolute tolerance of the URDF's mass; ``{"mass": "unknown"}``
            takes that mass for a scale only.
        gravity: [m/s^2] in the axes of the base.
        urdf_dynamics: ``use`` turns the URDF's <dynamics damping friction> into link-side effects; ``ignore`` leaves
            it out.
        rotor_coupling: ``reduced``: rotors act on their own joint only; ``full``: they move with their parent links,
            and their spin acts on the links (S(q) alpha and its gyroscopic torques).
        command: a default motion in the form of a command file with points (see `flexdyn.control.points`). ``flexdyn
            simulate`` uses it if no other command is given; in Python ``fd.simulate(model, model.command)``.
        name: of the model; default: the robot's.

    Raises:
        InputError: a joint, effect or number that does not fit the robot.

    Example:
        >>> drives = {"*": {"gear_ratio": 100, "rotor_inertia": 2e-5, "stiffness": 2e4, "damping": 20}}
        >>> model = fd.FlexibleJointModel(fd.load_robot("ur5"), joints=drives, effects=[fd.effects.Payload(mass=2.0)])
        >>> model.n, model.elastic.all()
        (6, np.True_)
    """

    def __init__(
        self,
        robot: Robot,
        joints: Mapping[str, Joint | Mapping[str, Any]] | None = None,
        effects: Iterable[Effect | Mapping[str, Any]] = (),
        *,
        initial: Mapping[str, Mapping[str, float]] | None = None,
        tolerance: float | Mapping[str, float] = 0.05,
        links: Mapping[str, Mapping[str, Any]] | None = None,
        gravity: Sequence[float] = EARTH,
        urdf_dynamics: str = "use",
        rotor_coupling: str = "reduced",
        command: Mapping[str, Any] | None = None,
        name: str = "",
    ) -> None:
        if not isinstance(robot, Robot):
            raise InputError("a Robot is needed", key="robot", value=robot, remedy="use fd.load_robot(...)")
        self.robot = robot
        self.name = name or robot.name
        listed = [each for each in effects if not isinstance(each, MotorLaw)]  # those come from the actuators
        tolerance, joints, links, listed = with_stated_tolerances(tolerance, joints, links, listed, robot)
        drives = resolve_joints({} if joints is None else joints, robot.joint_names)
        self.joints: Mapping[str, Joint] = MappingProxyType(drives)
        self.urdf_dynamics = one_of("robot.urdf_dynamics", urdf_dynamics, ("use", "ignore"))
        self.rotor_coupling = one_of("robot.rotor_coupling", rotor_coupling, ("reduced", "full"))
        if robot.axes and rotor_coupling == "full":
            remedy = "write reduced: the model does not say on which links the rotors of coupled axes ride"
            raise InputError("no rotor coupling with axes", key="robot.rotor_coupling", value="full", remedy=remedy)
        self.gravity = gravity_checked(gravity)
        self.initial = initial_checked({} if initial is None else initial, robot.joint_names)
        self.tolerance = tolerance_checked(tolerance)
        self.command = command_checked(command, robot.joint_names)
        self.links: Mapping[str, GivenNumber] = link_inertias({} if links is None else links, robot)
        self.effects: tuple[Effect, ...] = fitted(robot, self.joints, listed)
        self.urdf_effects: tuple[Effect, ...] = urdf_effects(robot) if urdf_dynamics == "use" else ()
        self.__dict__["_locked"] = True
        self.resolved()  # refuses parameter errors of numbers that do not exist

    def __setattr__(self, key: str, value: Any) -> None:
        """Refuse changes: models are immutable, `replace` makes a changed copy."""
        if self.__dict__.get("_locked"):
            raise AttributeError(f"a model does not change: use model.replace({key}=...)")
        super().__setattr__(key, value)

    def __delattr__(self, key: str) -> None:
        """Refuse to delete an attribute."""
        raise AttributeError(f"a model does not change: {key} stays")

    def __reduce__(self) -> tuple[Any, ...]:
        """Pickle by the constructor's arguments."""
        return (partial(FlexibleJointModel, **self._settings()), (self.robot, dict(self.joints), self.effects))

    def __eq__(self, other: object) -> bool:
        """Equal if robot source, joints, effects and settings are equal."""
        if not isinstance(other, FlexibleJointModel):
            return NotImplemented
        mine, its = self.robot, other.robot
        known = mine.source is not None
        same_robot = mine is its or (known and (mine.source, mine.lock, mine.axes) == (its.source, its.lock, its.axes))
        return same_robot and self._content() == other._content()

    def __hash__(self) -> int:
        """Hash of name and joints."""
        return hash((self.name, tuple(self.joints.values())))

    def __repr__(self) -> str:
        """A summary in one line."""
        numbers = f"{self.n} joints, {int(self.elastic.sum())} elastic, {len(self.all_effects)} effects"
        return visible(f"<FlexibleJointModel {self.name}: {numbers}>")

    def _repr_html_(self) -> str:
        """HTML for notebooks: drives and effects."""
        return as_card(self)

    @property
    def n(self) -> int:
        """Number of joints."""
        return self.robot.n

    @property
    def joint_names(self) -> tuple[str, ...]:
        """Names of the joints in the order of q."""
        return self.robot.joint_names

    @cached_property
    def stiffness(self) -> Array:
        """K of every joint (n,) [N m/rad or N/m], infinite where rigid; the effect joint_elasticity is included."""
        stiffness = self._numbers("stiffness")
        for joint, more in elasticities(self.effects):
            j = self.index(joint)
            stiffness[j] = more + (stiffness[j] if np.isfinite(stiffness[j]) else 0.0)
        return lock(stiffness)

    @cached_property
    def damping(self) -> Array:
        """D of every joint (n,) [N m s/rad or N s/m]."""
        return lock(self._numbers("damping"))

    @cached_property
    def rotor_inertia(self) -> Array:
        """J of every joint, reflected to the link side (n,) [kg m^2 or kg]."""
        return lock(self._numbers("reflected_inertia"))

    @cached_property
    def elastic(self) -> Flags:
        """Which joints have a finite stiffness (n,)."""
        return lock(np.isfinite(self.stiffness))

    @cached_property
    def rotor_places(self) -> Indices:
        """Where each joint's rotor stands in [q, theta of the elastic joints] (n,); that of a rigid joint at its q."""
        return lock(np.where(self.elastic, self.n + np.cumsum(self.elastic) - 1, np.arange(self.n)))

    @cached_property
    def all_effects(self) -> tuple[Effect, ...]:
        """The model's effects, then the laws of motors under voltage, then the effects of the URDF's <dynamics>."""
        return self.effects + self.motor_laws + self.urdf_effects

    @cached_property
    def motor_laws(self) -> tuple[MotorLaw, ...]:
        """The laws of the joints' actuators, which act on the commanded torques."""
        found: list[MotorLaw] = []
        for name, joint in self.joints.items():
            if joint.actuator is not None:
                found += joint.actuator.laws(name, joint.gear_ratio)
        return tuple(found)

    def replace(self, **changes: Any) -> FlexibleJointModel:
        """A copy with some of the constructor's arguments changed.

        Args:
            changes: as the constructor takes them; ``joints`` is merged number by number into the present joints.
        """
        if changes.keys() == {"initial"}:
            return self._starting(changes["initial"])
        joints: dict[str, Any] = dict(self.joints)
        for name, numbers in changes.pop("joints", {}).items():
            for each in self.joint_names if name == "*" else (name,):
                joints[each] = Joint.numbers(joints.get(each, {})) | Joint.numbers(numbers)
        robot, effects = changes.pop("robot", self.robot), changes.pop("effects", self.effects)
        return FlexibleJointModel(robot, joints, effects, **(self._settings() | changes))

    def resolved(self) -> FlexibleJointModel:
        """The model with parameter errors and joint elasticities applied to the numbers that they change.

        Without any of them it is the model itself. Plants are built from the resolved model.
        """
        return self._resolved

    def check_known(self) -> None:
        """Refuse a model with an unknown number: a computation needs all numbers.

        Raises:
            InputError: a number is unknown; the message says how to give it.
        """
        for name, joint in self.joints.items():
            slides = self.robot.angle_unit(name) == "m"
            for number in ("rotor_inertia", *(["stiffness", "damping"] if self.elastic[self.index(name)] else [])):
                if joint.given(number).is_unknown:
                    side = " on the motor side" if number == "rotor_inertia" else ""
                    raise refusal(f"joints.{name}.{number}", JOINT_UNITS[number][slides] + side)
        for name, number in unknown_of_motors(self.tolerance, self.joints):
            raise refusal(f"joints.{name}.actuator.dc_motor.{number}", MOTOR_UNITS[number])
        for name in unknown_links(self.links):
            raise refusal(f"links.{name}.inertia", "kg m^2")
        for name in unknown_masses(self.tolerance, self.robot.frame_names):
            raise refusal(f"links.{name}.mass", "kg")
        for i, name in unknown_parameters(self.tolerance, self.effects):
            units = units_of(self.robot, self.effects[i])
            raise refusal(f"effects[{i}].{name}", units[name])

    def rigid(self) -> FlexibleJointModel:
        """The same arm without elasticity: every joint rigid, J added to M, no effects that need a spring."""
        true = self.resolved()
        links = {signal: values for signal, values in self.initial.items() if signal in ("q", "v")}
        wound = [getattr(each, "side", None) == "transmission" or each.takes_load for each in true.effects]
        kept = [i for i, needs_spring in enumerate(wound) if not needs_spring]
        settings = {"tolerance": kept_tolerances(true.tolerance, kept), "initial": links}
        return true.replace(joints={"*": {"stiffness": math.inf}}, effects=[true.effects[i] for i in kept], **settings)

    def index(self, joint: str) -> int:
        """Index of a joint in q.

        Raises:
            InputError: the robot has no such joint.
        """
        return self.robot.joint_index(joint)

    def _starting(self, initial: Any) -> FlexibleJointModel:
        """The same model with another first state; checks and computed values are kept."""
        kept = {key: value for key, value in vars(self).items() if key != "_resolved"}
        twin = object.__new__(type(self))
        twin.__dict__.update(kept, initial=initial_checked({} if initial is None else initial, self.joint_names))
        return twin

    def _numbers(self, attribute: str) -> Array:
        return np.array([getattr(joint, attribute) for joint in self.joints.values()])

    def _settings(self) -> dict[str, Any]:
        keys = ("initial", "tolerance", "gravity", "urdf_dynamics", "rotor_coupling", "command", "name")
        return {key: plain(getattr(self, key)) for key in keys} | {"links": links_entry(self.links)}

    def _content(self) -> tuple[Any, ...]:
        return dict(self.joints), self.effects, self._settings()

    @cached_property
    def _resolved(self) -> FlexibleJointModel:
        """The model with parameter errors and elasticities in its numbers; itself if it has none."""
        acting = [effect for effect in self.effects if not effect.is_neutral]
        told = any(not number.is_unknown for number in self.links.values())
        if not told and not any(effect.in_numbers for effect in acting):
            return self
        robot, joints, effects = folded(robot_with_links(self.robot, self.links), self.joints, self.effects)
        kept = [i for i, effect in enumerate(self.effects) if not effect.in_numbers]
        changed = {"links": unknown_links(self.links), "tolerance": kept_tolerances(self.tolerance, kept)}
        return FlexibleJointModel(robot, joints, effects, **self._settings() | changed)
