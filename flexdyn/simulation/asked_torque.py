"""The commanded torque of motors under voltage, from recorded volts, duties, or goals of a servo's firmware."""

from __future__ import annotations

import numpy as np

from flexdyn import _core
from flexdyn.arrays import Array
from flexdyn.control.firmware import Firmware
from flexdyn.errors import InputError
from flexdyn.model.actuator import Actuator
from flexdyn.model.flexible_joint_model import FlexibleJointModel
from flexdyn.records import Recording

ASKED = ("voltage", "duty", "goal")
"""Signals that command a motor under voltage; the first that was recorded is used."""


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
    if not columns:
        return recording
    channels = {key: values for key, values in recording.items() if key != "t"}
    return Recording(recording.t, channels | columns, meta=dict(recording.meta), name=recording.name)


def is_of_goals(model: FlexibleJointModel, recording: Recording) -> bool:
    """Whether a recording has goals of the model's servos and not the voltages of their motors."""
    driven = [name for name, joint in model.joints.items() if joint.actuator is not None and joint.actuator.firmware]
    return bool(driven) and all(_asked(recording, name) == "goal" for name in driven)


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
        remedy = (
            f"record voltage.{joint} or duty.{joint}, or take the actuator out of the model where tau is its torque"
        )
        raise InputError(
            "the joint's motor is under voltage", key=f"voltage.{joint}", file=recording.name or None, remedy=remedy
        )
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
