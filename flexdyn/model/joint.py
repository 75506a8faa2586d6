"""The drive of one joint: gear, rotor, spring and damper between motor and link."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, fields
from typing import Any

from flexdyn.checks import check_known, number
from flexdyn.errors import InputError, placed
from flexdyn.model.actuator import Actuator
from flexdyn.model.given_number import UNKNOWN, GivenNumber, given_number

JOINT_UNITS = {
    "gear_ratio": ("1", "rad/m"),
    "rotor_inertia": ("kg m^2", "kg m^2"),
    "stiffness": ("N m/rad", "N/m"),
    "damping": ("N m s/rad", "N s/m"),
}
"""Units of a drive's numbers where its joint turns and where it slides."""


@dataclass(frozen=True, kw_only=True)
class Joint:
    """The drive of one joint; all numbers except rotor_inertia are on the link side of the gear.

    Every number but the gear ratio may be given with an absolute tolerance, one standard deviation in its own unit:
    ``{"value": 0.0, "tolerance": 2e-5}``. It may also be ``"unknown"``: a diagnosis estimates it.

    Args:
        gear_ratio: N = motor angle / link angle [1]; on a prismatic joint [rad/m]; negative where the motor turns the
            other way.
        rotor_inertia: on the motor side [kg m^2]; J = gear_ratio^2 rotor_inertia.
        stiffness: K [N m/rad or N/m]; infinite: a rigid joint; 0 where it is unknown.
        damping: D across the transmission [N m s/rad or N s/m]; it has no effect in a rigid joint.
        actuator: an `Actuator` or its mapping, if the motor is driven by a voltage; None: by a torque.
        tolerances: absolute ones by name of the number; infinite: the number is unknown. Taken from the numbers if
            these have one.

    Raises:
        InputError: a number that is not allowed: negative inertia, zero stiffness, an elastic joint whose rotor has no
            inertia.

    Example:
        >>> joint = fd.Joint(gear_ratio=100.0, rotor_inertia=2e-5, stiffness=2e4)
        >>> joint.rotor_inertia * joint.gear_ratio**2  # reflected
        0.2
    """

    gear_ratio: float = 1.0
    rotor_inertia: float = 0.0
    stiffness: float = math.inf
    damping: float = 0.0
    actuator: Actuator | None = None
    tolerances: tuple[tuple[str, float], ...] = ()

    def __post_init__(self) -> None:
        """Check every number."""
        object.__setattr__(self, "actuator", Actuator.of(self.actuator))
        self._read()
        if self.gear_ratio == 0 or math.isinf(self.gear_ratio):
            raise InputError("it must be finite and not 0", key="gear_ratio", value=self.gear_ratio)
        if self.stiffness < 0 or (self.stiffness == 0 and not self.given("stiffness").is_unknown):
            remedy = "use .inf for a rigid joint"
            raise InputError("it must be above 0", key="stiffness", value=self.stiffness, remedy=remedy)
        for name in ("rotor_inertia", "damping"):
            number(name, getattr(self, name), "it must be finite and at least 0", least=0.0)
        if self.elastic and self.rotor_inertia == 0 and not self.given("rotor_inertia").is_unknown:
            remedy = "give the rotor's inertia in kg m^2 on the motor side, or stiffness .inf for a rigid joint"
            raise InputError("an elastic joint needs it above 0", key="rotor_inertia", remedy=remedy)
        if self.rotor_inertia > 0 and not 0 < self.reflected_inertia < math.inf:
            problem = "gear_ratio^2 rotor_inertia is too large for a double"
            raise InputError(problem, key="rotor_inertia", value=self.rotor_inertia)

    @property
    def elastic(self) -> bool:
        """Whether its stiffness is finite, known or not."""
        return math.isfinite(self.stiffness)

    @property
    def reflected_inertia(self) -> float:
        """J = gear_ratio^2 rotor_inertia [kg m^2 or kg]."""
        return self.gear_ratio * self.gear_ratio * self.rotor_inertia

    def given(self, name: str) -> GivenNumber:
        """A number with its absolute tolerance, if it has one."""
        return GivenNumber(getattr(self, name), dict(self.tolerances).get(name))

    def to_dict(self) -> dict[str, Any]:
        """As a model file writes it."""
        numbers = {name: self.given(name).entry() for name in NUMBERS}
        return numbers if self.actuator is None else numbers | {"actuator": self.actuator.to_dict()}

    def values(self) -> dict[str, Any]:
        """Every number without its tolerance; ``unknown`` for an unknown one."""
        return {name: UNKNOWN if self.given(name).is_unknown else getattr(self, name) for name in NUMBERS}

    @staticmethod
    def numbers(entry: Any) -> dict[str, Any]:
        """The keys of a model file's entry, checked by name; their values are checked by the constructor.

        Raises:
            InputError: it is no mapping, or has a key that a joint does not have.
        """
        if isinstance(entry, Joint):
            return entry.to_dict() | {"actuator": entry.actuator}
        if not isinstance(entry, Mapping):
            remedy = "write {stiffness: 4000.0, ...}"
            raise InputError("a joint is a mapping of its numbers", value=entry, remedy=remedy)
        for key in entry:
            check_known(key, JOINT_KEYS, "a joint has no such key", key=str(key))
        return {str(key): value for key, value in entry.items()}

    def _read(self) -> None:
        """Take values and absolute tolerances from the given entries."""
        tolerances = dict(self.tolerances)
        for name in NUMBERS:
            number = given_number(getattr(self, name), name)
            if number.value != 0.0 and tolerances.get(name) == math.inf:
                del tolerances[name]  # it was unknown and now has a value
            if number.tolerance is not None:
                if name == "gear_ratio":
                    raise InputError("it must be a number", key=name, value=number.entry(), remedy=RATIO_KNOWN)
                tolerances[name] = number.tolerance
            object.__setattr__(self, name, number.value)
        object.__setattr__(self, "tolerances", tuple(sorted(tolerances.items())))


JOINT_KEYS = tuple(field.name for field in fields(Joint) if field.name != "tolerances")
"""Keys of a joint in a model file."""
NUMBERS = tuple(name for name in JOINT_KEYS if name != "actuator")
"""Names of a joint's numbers."""
RATIO_KNOWN = "all signals are reflected, so a wrong one shows in the rotor's inertia: make rotor_inertia unknown"
"""Why a gear ratio may not be unknown."""


def resolve_joints(entries: Mapping[str, Any], names: tuple[str, ...]) -> dict[str, Joint]:
    """A drive for every joint: its own numbers, else those of ``"*"``, else the defaults.

    Args:
        entries: joint name or ``"*"`` -> `Joint` or mapping of its numbers.
        names: of the robot's joints.

    Raises:
        InputError: a joint that the robot does not have, or a number that is not allowed.
    """
    if not isinstance(entries, Mapping):
        raise InputError("joints are a mapping by name", key="joints", value=entries)
    for name in entries:
        if name != "*":
            check_known(name, names, "the robot has no such joint", key=f"joints.{name}")
    resolved: dict[str, Joint] = {}
    for name in names:
        given = entries.get(name)
        if isinstance(given, Joint):  # it has every number, checked
            resolved[name] = given
            continue
        shared, own = (_entry(entries, key) for key in ("*", name))
        try:
            resolved[name] = Joint(**(shared | own))
        except InputError as error:
            # An error names the entry that gave the number; a missing number is reported at the joint itself.
            number = str(error.key).partition(".")[0]
            inherited = name not in entries or (number in shared and number not in own)
            raise error.at(key=f"joints.{'*' if inherited else name}") from None
    return resolved


def _entry(entries: Mapping[str, Any], name: str) -> dict[str, Any]:
    with placed(key=f"joints.{name}"):
        return Joint.numbers(entries.get(name, {}))
