"""The actuator of a joint: a DC motor under voltage, and the position controller in its firmware."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping
from typing import Any

from flexdyn.checks import number
from flexdyn.control.firmware import Firmware
from flexdyn.effects.motor import MotorLaw, MotorTorque, MotorWinding, SupplyLimit
from flexdyn.errors import InputError, placed
from flexdyn.io.yaml import check_keys


@dataclasses.dataclass(frozen=True, kw_only=True)
class DCMotor:
    """A DC motor with a voltage at its terminals, all numbers on the motor's side of the gear.

    ``tau = kt i``, ``V = R i + L i' + kt omega``, the current cut at its limit and the voltage at the supply. Without
    inductance ``tau = kt V/R - (kt^2/R) omega``. L/R of small motors is below 1 ms, so that it may mostly be left out.

    Args:
        torque_constant: kt [N m/A], which is the back-EMF constant [V s/rad] as well.
        resistance: R of the winding and its driver [ohm].
        supply: largest voltage [V], which a duty of 1 gives; infinite: no limit, and a duty has no meaning.
        current_limit: [A]; infinite: none.
        inductance: L of the winding [H]; 0: the current follows the voltage at once. A run starts without current.

    Raises:
        InputError: a number that is not above 0 (an inductance below 0), or not finite where it must be.

    Example:
        >>> motor = fd.DCMotor(torque_constant=0.05, resistance=2.0, supply=12.0)
        >>> round(motor.stall_torque(gear_ratio=100.0) * motor.supply, 6)  # behind a gear, N m
        30.0
    """

    torque_constant: float
    resistance: float
    supply: float = math.inf
    current_limit: float = math.inf
    inductance: float = 0.0

    def __post_init__(self) -> None:
        """Check every number."""
        for name in MOTOR_UNITS:
            value = getattr(self, name)
            if name == "inductance":
                checked = number(name, value, "it must be finite and at least 0", least=0.0)
            else:
                infinite = name in ("supply", "current_limit")
                checked = number(name, value, "a number above 0 is needed", above=0.0, infinite=infinite)
            object.__setattr__(self, name, checked)

    def stall_torque(self, gear_ratio: float) -> float:
        """Torque per volt at standstill behind a gear, ``N kt/R`` [N m/V]."""
        return gear_ratio * self.torque_constant / self.resistance

    def to_dict(self) -> dict[str, float]:
        """As a model file writes it: limits that are none and an inductance of 0 are left out."""
        written = {key: value for key, value in dataclasses.asdict(self).items() if math.isfinite(value)}
        return {key: value for key, value in written.items() if key != "inductance" or value > 0.0}


MOTOR_UNITS = {"torque_constant": "N m/A", "resistance": "ohm", "supply": "V", "current_limit": "A", "inductance": "H"}
"""Units of a DC motor's numbers."""


@dataclasses.dataclass(frozen=True, kw_only=True)
class Actuator:
    """The drive of a joint's motor whose command is a voltage, not a torque.

    A recording holds the command as ``voltage.JOINT`` [V], ``duty.JOINT`` [1], or, with firmware, ``goal.JOINT`` [rad].
    The signal ``tau`` is then the torque that this voltage gives at standstill.

    Args:
        dc_motor: a `DCMotor` or the mapping of its numbers.
        firmware: a `Firmware`, the mapping of its settings, or None if the voltage is commanded directly.
        torque_per_volt: factor from the voltage to the commanded torque at standstill, behind the gear [N m/V]; None:
            computed from the motor's numbers. A diagnosis keeps it fixed when it changes these numbers.

    Raises:
        InputError: a number that is not allowed.

    Example:
        >>> servo = fd.Actuator(dc_motor=fd.DCMotor(torque_constant=0.5, resistance=5.0, supply=12.0))
        >>> model = fd.load_model("scara_two_link").replace(joints={"elbow": {"actuator": servo}})
        >>> volts = fd.Recording([0.0, 0.5, 1.0], {"voltage.elbow": [6.0, 6.0, 6.0], "tau.shoulder": [0.0, 0.0, 0.0]})
        >>> run = fd.simulate(model, volts)
        >>> bool(abs(run.electrical.current[0, 1] - 6.0 / 5.0) < 1e-12)
        True
    """

    dc_motor: DCMotor
    firmware: Firmware | None = None
    torque_per_volt: float | None = None

    def __post_init__(self) -> None:
        """Convert mappings to the objects that they describe."""
        for name, kind in (("dc_motor", DCMotor), ("firmware", Firmware)):
            value = getattr(self, name)
            if isinstance(value, kind) or (value is None and name == "firmware"):
                continue
            object.__setattr__(self, name, _made(name, kind, value))

    def per_volt(self, gear_ratio: float) -> float:
        """Commanded torque per volt [N m/V]."""
        return self.dc_motor.stall_torque(gear_ratio) if self.torque_per_volt is None else self.torque_per_volt

    def laws(self, joint: str, gear_ratio: float) -> tuple[MotorLaw, ...]:
        """The laws that act on the commanded torque, behind the gear.

        Args:
            joint: its name.
            gear_ratio: of the joint [1].

        Returns:
            The limit of the supply, if there is one, and the law of the torque.
        """
        motor, asked = self.dc_motor, self.per_volt(gear_ratio)
        kt = gear_ratio * motor.torque_constant
        gain, back_emf = kt / motor.resistance / asked, kt * kt / motor.resistance
        most = abs(kt) * motor.current_limit
        torque: MotorLaw = MotorTorque(joint, gain=gain, back_emf=back_emf, limit=most)
        if motor.inductance > 0.0:
            lag = motor.inductance / motor.resistance
            torque = MotorWinding(joint, gain=gain, back_emf=back_emf, limit=most, time_constant=lag)
        limit = SupplyLimit(joint, limit=abs(asked) * motor.supply)
        return (torque,) if limit.is_neutral else (limit, torque)

    def changed(self, **numbers: float) -> Actuator:
        """A copy with other numbers of the motor."""
        return dataclasses.replace(self, dc_motor=dataclasses.replace(self.dc_motor, **numbers))

    def scaled(self, number: str, factor: float) -> Actuator:
        """A copy with one number of the motor multiplied by a factor."""
        return self.changed(**{number: getattr(self.dc_motor, number) * factor})

    def held(self, gear_ratio: float) -> Actuator:
        """A copy that keeps the present factor from volts to commanded torque when its numbers or the gear change."""
        return dataclasses.replace(self, torque_per_volt=self.per_volt(gear_ratio))

    def to_dict(self) -> dict[str, Any]:
        """As a model file writes it."""
        content: dict[str, Any] = {"dc_motor": self.dc_motor.to_dict()}
        return content if self.firmware is None else content | {"firmware": dataclasses.asdict(self.firmware)}

    @staticmethod
    def of(entry: Any) -> Actuator | None:
        """Make an actuator from a model file's entry; an actuator is returned as it is.

        Raises:
            InputError: no mapping of ``dc_motor`` and ``firmware``, or a number that is not allowed.
        """
        if entry is None or isinstance(entry, Actuator):
            return entry
        try:
            made: Actuator = _made("actuator", Actuator, entry, ("dc_motor", "firmware"))
            return made
        except InputError as error:
            raise error if (error.key or "").startswith("actuator") else error.at(key="actuator") from None


def _made(name: str, kind: Any, entry: Any, allowed: tuple[str, ...] = ()) -> Any:
    """Make a frozen settings class from a mapping of its fields."""
    fields = {field.name: field for field in dataclasses.fields(kind)}
    known = allowed or tuple(fields)
    if not isinstance(entry, Mapping):
        raise InputError("a mapping is needed", key=name, value=entry, remedy=f"its keys are {', '.join(known)}")
    required = [key for key in known if fields[key].default is dataclasses.MISSING]
    check_keys(entry, known, required=required, key=name)
    with placed(key=name):
        return kind(**entry)
