"""Motors under voltage: the torque that recorded volts ask for, and the volts, amperes and heat of a run."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from flexdyn import _core
from flexdyn.arrays import Array
from flexdyn.control.firmware import Firmware
from flexdyn.effects.actuator import ActuatorEffect
from flexdyn.errors import InputError
from flexdyn.model.actuator import Actuator
from flexdyn.model.flexible_joint_model import FlexibleJointModel
from flexdyn.records import Recording
from flexdyn.records.signals.cut import with_channels
from flexdyn.simulation.laws import acting_effects

ASKED = ("voltage", "duty", "goal")
"""Signals that command a motor under voltage; the first that was recorded is used."""
ROUNDING = 1e-12
"""Part of a limit that a current at it may be off."""


def with_asked_torque(model: FlexibleJointModel, recording: Recording) -> Recording:
    """Add ``tau`` of every joint whose motor is under voltage: the torque of that voltage at standstill.

    The firmware's law turns a goal into a duty along the measured positions. It is computed at the firmware's rate
    between the samples. Each sample gets the mean until the next one, which has the same impulse.

    Args:
        model: that has the actuators.
        recording: of the joints.

    Returns:
        The recording itself where no joint has an actuator.

    Raises:
        InputError: such a joint without voltage, duty or goal; a duty without a supply; a goal without firmware.
    """
    columns = {}
    for name, joint in model.joints.items():
        if joint.actuator is not None:
            volts = _volts(joint.actuator, recording, name)
            columns[f"tau.{name}"] = joint.actuator.per_volt(joint.gear_ratio) * volts
    return with_channels(recording, columns) if columns else recording


def is_of_goals(model: FlexibleJointModel, recording: Recording) -> bool:
    """Whether a recording has goals of the model's servos and not the voltages of their motors."""
    driven = firmware_by_joint(model)
    return bool(driven) and all(_asked(recording, name) == "goal" for name in driven)


def firmware_by_joint(model: FlexibleJointModel) -> dict[str, Firmware]:
    """The firmware of every joint whose servo has one."""
    driven = ((name, joint.actuator) for name, joint in model.joints.items() if joint.actuator is not None)
    return {name: actuator.firmware for name, actuator in driven if actuator.firmware is not None}


def firmware_duty(firmware: Firmware, goal: Array, position: Array) -> Array:
    """Duty at each tick (ticks,) [1]; the controller starts at rest.

    Args:
        firmware: its settings.
        goal: at the ticks (ticks,) [rad].
        position: likewise.
    """
    duty = np.empty(len(goal))
    table = np.array([firmware.numbers])
    _core.firmware_duty(table, np.ascontiguousarray(goal), np.ascontiguousarray(position), duty)
    return duty


def _asked(recording: Recording, joint: str) -> str | None:
    return next((signal for signal in ASKED if recording.has(signal, joint)), None)


def _volts(actuator: Actuator, recording: Recording, joint: str) -> Array:
    """Commanded voltage (samples,) [V]."""
    signal = _asked(recording, joint)
    if signal is None:
        key, file, instead = f"voltage.{joint}", recording.name or None, f"duty.{joint}"
        remedy = f"record {key} or {instead}, or take the actuator out of the model where tau is its torque"
        raise InputError("the joint's motor is under voltage", key=key, file=file, remedy=remedy)
    if signal == "voltage":
        return recording[f"voltage.{joint}"]
    supply = actuator.dc_motor.supply
    if not np.isfinite(supply):
        remedy = f"give joints.{joint}.actuator.dc_motor.supply in V"
        raise InputError(f"{signal}.{joint} needs the supply", key=f"{signal}.{joint}", remedy=remedy)
    duty = recording[f"duty.{joint}"] if signal == "duty" else _duty_of_goal(actuator, recording, joint)
    return supply * np.clip(duty, -1.0, 1.0)


def _duty_of_goal(actuator: Actuator, recording: Recording, joint: str) -> Array:
    """Mean duty from each sample to the next (samples,)."""
    from scipy.interpolate import CubicSpline

    firmware = actuator.firmware
    if firmware is None:
        remedy = f"give joints.{joint}.actuator.firmware, or record duty.{joint}"
        raise InputError("a goal needs the servo's firmware", key=f"goal.{joint}", remedy=remedy)
    seen = next((f"{signal}.{joint}" for signal in ("theta", "q") if recording.has(signal, joint)), None)
    if seen is None:
        raise InputError("a goal needs a position", key=f"goal.{joint}", remedy=f"record theta.{joint} or q.{joint}")
    t = recording.t
    ticks = t[0] + np.arange(int((t[-1] - t[0]) * firmware.rate + 1e-6) + 1) / firmware.rate
    rows = np.clip(np.searchsorted(t, ticks + 1e-3 / firmware.rate, "right") - 1, 0, None)
    duty = firmware_duty(firmware, recording[f"goal.{joint}"][rows], CubicSpline(t, recording[seen])(ticks))
    summed = np.concatenate([[0.0], np.cumsum(duty)]) / firmware.rate
    impulse = np.interp(t, np.append(ticks, ticks[-1] + 1.0 / firmware.rate), summed)
    return np.append(np.diff(impulse) / np.diff(t), duty[-1])


@dataclass(frozen=True, eq=False)
class Electrical:
    """Electrical quantities of every joint's motor at the samples (samples, n); NaN where a joint has no DC motor.

    Attributes:
        voltage: at the motor's terminals [V]: as asked for, but where the supply or the current's limit cuts it; with
            inductance ``R i + L i' + kt omega``.
        current: [A].
        power: voltage times current [W]; the rest of it beside `heat` is mechanical, and with inductance magnetic.
        heat: R current^2 [W].

    Example:
        >>> motor = {"actuator": {"dc_motor": {"torque_constant": 0.5, "resistance": 5.0, "supply": 12.0}}}
        >>> model = fd.load_model("scara_two_link").replace(joints={"elbow": motor})
        >>> run = fd.simulate(model, fd.Samples([0.0, 1.0], {"elbow": [0.2, 0.2]}))
        >>> mechanical = run.tau_applied[:, 1] * run.omega[:, 1]
        >>> bool(np.allclose(run.electrical.power[:, 1], run.electrical.heat[:, 1] + mechanical))
        True
    """

    voltage: Array
    current: Array
    power: Array
    heat: Array


def asked_voltage(model: FlexibleJointModel, tau: Array) -> Array:
    """Voltages of the commanded torques (samples, n) [V], limited to the supply; NaN without a motor.

    Args:
        model: that has the actuators.
        tau: commanded torques (samples, n) [N m or N].
    """
    volts = np.full_like(tau, np.nan)
    for j, joint in enumerate(model.joints.values()):
        if joint.actuator is not None:
            supply = joint.actuator.dc_motor.supply
            volts[:, j] = np.clip(tau[:, j] / joint.actuator.per_volt(joint.gear_ratio), -supply, supply)
    return volts


def electrical(model: FlexibleJointModel, tau: Array, omega: Array, z: Array) -> Electrical:
    """Of motors that are asked for torques while they turn.

    Args:
        model: that has the actuators.
        tau: commanded torques (samples, n) [N m or N].
        omega: rotor speeds, reflected (samples, n).
        z: internal states of the plant (samples, number of them): of currents with inductance among them.
    """
    volts, true = asked_voltage(model, tau), model.resolved()
    current, heat = np.full_like(tau, np.nan), np.full_like(tau, np.nan)
    for j, joint in enumerate(true.joints.values()):
        if joint.actuator is None:
            continue
        motor = joint.actuator.dc_motor
        kt = joint.gear_ratio * motor.torque_constant
        # What dc_motor and dc_winding of laws.hpp make of volts, as a current.
        free = (volts[:, j] - kt * omega[:, j]) / motor.resistance
        if motor.inductance == 0.0:
            current[:, j] = np.clip(free, -motor.current_limit, motor.current_limit)
            volts[:, j] = motor.resistance * current[:, j] + kt * omega[:, j]
        else:
            current[:, j] = z[:, winding_states(true)[true.joint_names[j]]] / kt
            held = np.abs(current[:, j]) >= motor.current_limit * (1.0 - ROUNDING)
            held &= free * current[:, j] >= current[:, j] ** 2
            volts[held, j] = motor.resistance * current[held, j] + kt * omega[held, j]
        heat[:, j] = motor.resistance * current[:, j] ** 2
    return Electrical(volts, current, volts * current, heat)


def winding_states(model: FlexibleJointModel) -> dict[str, int]:
    """Joint of every motor with inductance -> place of its current's torque among the internal states."""
    kept = [effect for effect in acting_effects(model) if effect.has_state]
    return {effect.joint: place for place, effect in enumerate(kept) if isinstance(effect, ActuatorEffect)}
