"""Prepare a command (torques, a controller, a recording, a file) for the core."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from flexdyn import _core
from flexdyn.arrays import Array
from flexdyn.control.commands import PD, Controller, State
from flexdyn.control.firmware import CORE_ORDER, Firmware
from flexdyn.control.points import CommandPoints
from flexdyn.control.samples import Samples
from flexdyn.control.servo import Servo
from flexdyn.control.setting_checks import Interpolation, per_joint
from flexdyn.errors import InputError
from flexdyn.model.flexible_joint_model import FlexibleJointModel
from flexdyn.records import Recording
from flexdyn.simulation.electrical import firmware_by_joint, is_of_goals, with_asked_torque
from flexdyn.simulation.given_command import called, check_command, measured_state, recorded, resolve_command

FirstState = Mapping[str, Mapping[str, float]]
RECORDED: Interpolation = "monotone"
"""Default interpolation of a recorded reference: through its samples, never outside the range of two neighbours."""


@dataclass(frozen=True)
class Drive:
    """A command prepared for one model.

    Attributes:
        command: for the core.
        duration: of the command [s]; None if it has no end.
        initial: first state that a recording measured: signal -> joint -> value.
        samples: torques of an open-loop command, one column for each joint; None for controllers and for no torque.
        notes: what the user should know about it, one sentence each.
        controller: the controller that closes the loop; None for torques over time.
        reference: positions that are tracked, one column for each joint; None if there are none.
    """

    command: _core.Command
    duration: float | None
    initial: FirstState
    samples: Samples | None = None
    notes: tuple[str, ...] = ()
    controller: PD | Servo | Controller | None = None
    reference: Samples | None = None


def make_drive(model: FlexibleJointModel, command: Any, duration: float | None) -> Drive:
    """Prepare a command for a model.

    Args:
        model: whose joints it drives.
        command: None (no torque), `Samples`, `PD`, `Servo`, `Controller`, a `Recording` (its tau columns, held), the
            path of a recording or of a YAML file with ``pd:`` or ``torques:``, a mapping of such a file's keys with
            points (see `flexdyn.control.points`), or n constant torques.
        duration: of the run, if it is known [s]; constant torques last so long.

    Raises:
        InputError: a command that does not fit the model.
    """
    command = resolve_command(command)
    if command is None:
        return Drive(_core.open_loop(None), None, {})
    if isinstance(command, Recording) and is_of_goals(model, command):
        return _servo(model, Servo(reference=command, firmware=firmware_by_joint(model)))
    if isinstance(command, Recording):
        samples = recorded(with_asked_torque(model, command), "tau", model.joint_names)
        made = _open_loop(samples, model, command.duration, measured_state(command, model))
        return replace(made, notes=_gaps("command", command, "its last value is held"))
    if isinstance(command, Samples):
        return _open_loop(command, model, command.duration, {})
    if isinstance(command, PD):
        return _tracking(model, command)
    if isinstance(command, Servo):
        return _servo(model, command)
    if isinstance(command, Controller):
        return Drive(_core.controller(_controller_call(command), command.rate), None, {}, controller=command)
    check_command(command)
    torques = per_joint("command", command, model.joint_names)
    end = 1.0 if duration is None else duration
    return _open_loop(Samples([0.0, max(end, 1e-9)], np.array([torques, torques])), model, None, {})


def _open_loop(samples: Samples, model: FlexibleJointModel, duration: float | None, initial: FirstState) -> Drive:
    """Torques over time, shifted so that they start with the run."""
    whole = Samples(samples.t - samples.t[0], samples.columns(model.joint_names), samples.interpolation)
    return Drive(_core.open_loop(_signal(whole, model.joint_names)), duration, initial, whole)


def _tracking(model: FlexibleJointModel, pd: PD) -> Drive:
    """A PD controller: its reference and feedforward as signals, and the first state that a recording states."""
    names = model.joint_names
    reference, ahead = resolve_command(pd.reference), resolve_command(pd.feedforward)
    initial: FirstState = {}
    notes: tuple[str, ...] = ()
    if isinstance(reference, Recording):
        initial = measured_state(reference, model)
        notes = _gaps("reference", reference, "it is interpolated")
        held = recorded(reference, "q" if "q" in reference.signals else "theta", names)
        reference = Samples(held.t, held.columns(names), pd.interpolation or RECORDED)
    _check_reference("pd.reference", reference)
    if isinstance(reference, CommandPoints):
        initial = {"q": {joint: float(reference.values[0, k]) for k, joint in enumerate(reference.joints or ())}}
        reference = reference.whole(names, model.initial.get("q", {}))
    if isinstance(ahead, Recording):
        ahead = recorded(ahead, "tau", names)
    if ahead is not None and not isinstance(ahead, Samples):
        raise InputError("Samples or a recording is needed", key="pd.feedforward", value=ahead)
    reference = _whole(reference, names)
    added = None if ahead is None else _signal(ahead, names)
    kp, kd = (per_joint(f"pd.{key}", getattr(pd, key), names).tolist() for key in ("kp", "kd"))
    command = _core.tracking(_signal(reference, names), added, kp, kd, pd.feedback == "theta", pd.rate)
    return Drive(command, reference.duration, initial, notes=notes, controller=pd, reference=reference)


def _gaps(what: str, recording: Recording, done: str) -> tuple[str, ...]:
    """A sentence for each gap in the recording that drives the arm."""
    return tuple(
        f"the {what} has a gap of {end - start:.4g} s from t = {start:.6g} s on, over which {done}"
        for start, end in recording.gaps
    )


def _servo(model: FlexibleJointModel, servo: Servo) -> Drive:
    """A servo: its firmware in the core, or its law as a controller."""
    reference = resolve_command(servo.reference)
    initial: FirstState = {}
    if isinstance(reference, Recording):
        initial = measured_state(reference, model)
        known = ("goal", "reference", "theta", "q")
        there = {name.partition(".")[0] for name in reference.channels if name.partition(".")[2] in model.joint_names}
        signal = next((name for name in known if name in there), "reference")
        reference = recorded(reference, signal, model.joint_names)
    _check_reference("servo.reference", reference)
    if servo.firmware is not None:
        command = _firmware(model, servo, reference)
    else:
        law = Controller(servo.law(reference, model.joint_names), servo.rate)
        command = _core.controller(_controller_call(law), servo.rate)
    controller = servo if servo.firmware is None else None
    reference = _whole(reference, model.joint_names)
    return Drive(command, reference.duration, initial, controller=controller, reference=reference)


def _firmware(model: FlexibleJointModel, servo: Servo, reference: Samples) -> _core.Command:
    """The firmware of every joint; its duty is expressed as the torque of that voltage at standstill."""
    each = servo.firmware if isinstance(servo.firmware, Mapping) else dict.fromkeys(model.joint_names, servo.firmware)
    settings, torques = np.zeros((model.n, len(CORE_ORDER))), np.zeros(model.n)
    for j, (name, joint) in enumerate(model.joints.items()):
        own, actuator = each.get(name), joint.actuator
        if not isinstance(own, Firmware):
            raise InputError("a Firmware is needed", key=f"servo.firmware.{name}", remedy="give every joint one")
        if actuator is None or not np.isfinite(actuator.dc_motor.supply):
            remedy = f"give joints.{name}.actuator.dc_motor with its supply in V"
            raise InputError("firmware needs a motor under voltage", key=f"servo.firmware.{name}", remedy=remedy)
        settings[j] = own.numbers
        torques[j] = actuator.per_volt(joint.gear_ratio) * actuator.dc_motor.supply
    goals = np.ascontiguousarray(servo.goals(reference, model.joint_names))
    return _core.firmware(goals, settings, torques, servo.delay, servo.feedback == "theta")


def _check_reference(key: str, reference: Any) -> None:
    """Refuse what cannot be tracked."""
    if isinstance(reference, Samples):
        return
    remedy = "give Samples, a recording or its path"
    if callable(reference):
        remedy = "a function is sampled first: fd.Samples(t, [position(x) for x in t], 'cubic')"
        reference = called(reference)
    raise InputError("no reference to track", key=key, value=reference, remedy=remedy)


def _whole(samples: Samples, joint_names: Sequence[str]) -> Samples:
    """The samples with a column for each joint."""
    return Samples(samples.t, samples.columns(joint_names), samples.interpolation)


def _signal(samples: Samples, joint_names: Sequence[str]) -> _core.Signal:
    return _core.signal(*samples.pieces(samples.columns(joint_names)))


def _controller_call(controller: Controller) -> Any:
    """What the core calls: a controller with plain arrays."""

    def call(t: float, q: Array, v: Array, theta: Array, omega: Array) -> Array:
        """The law's torques at one instant, which must be finite."""
        tau = np.atleast_1d(np.asarray(controller.law(t, State(q, v, theta, omega)), dtype=float))
        if tau.shape != q.shape or not np.isfinite(tau).all():
            remedy = f"it must return {len(q)} finite torques"
            raise InputError("the controller returned no valid torque", key=f"t = {t:g} s", value=tau, remedy=remedy)
        return np.ascontiguousarray(tau)

    return call
