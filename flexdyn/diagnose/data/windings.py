"""Motors with inductance: the lag of their current is computed once from the recorded volts and positions.

``L i' = V - R i - k omega`` is linear. So the equations are those of a motor without inductance, at whose terminals is
the voltage that would give the same current at once: ``R i + k omega``.
"""

from __future__ import annotations

import math

import numpy as np

from flexdyn.arrays import Array
from flexdyn.errors import InputError
from flexdyn.model.actuator import Actuator
from flexdyn.model.flexible_joint_model import FlexibleJointModel
from flexdyn.records import Recording
from flexdyn.records.signals.cut import with_channels


def without_inductance(model: FlexibleJointModel) -> FlexibleJointModel:
    """The model whose currents follow their voltages at once; the same if it has no inductance.

    What `with_lagging_current` makes of a recording is cut at the supply already: these motors have none.
    """
    changed = {
        name: {"actuator": actuator.changed(inductance=0.0, supply=math.inf)}
        for name, actuator in _windings(model).items()
    }
    return model.replace(joints=changed) if changed else model


def with_inductance(model: FlexibleJointModel, given: FlexibleJointModel) -> FlexibleJointModel:
    """A model from `without_inductance` with the inductance and the supply of the given one."""
    changed = {}
    for name, actuator in _windings(given).items():
        motor, now = actuator.dc_motor, model.joints[name].actuator
        if now is not None:
            changed[name] = {"actuator": now.changed(inductance=motor.inductance, supply=motor.supply)}
    return model.replace(joints=changed) if changed else model


def with_lagging_current(model: FlexibleJointModel, recording: Recording) -> Recording:
    """The recording with the torques that motors without inductance would be asked for to have the same currents.

    Voltages are held between samples, and speeds are the means between them; the current between two samples is then
    exact, and its mean counts. A current at its limit stays there. At the first sample it is settled.

    Args:
        model: with its inductances.
        recording: with the ``tau`` that its volts give at standstill.

    Raises:
        InputError: a motor with inductance whose position was not recorded.
    """
    columns = {}
    for name, actuator in _windings(model).items():
        seen = next((f"{signal}.{name}" for signal in ("theta", "q") if recording.has(signal, name)), None)
        if seen is None:
            remedy = f"record theta.{name} or q.{name}"
            raise InputError(
                "the current of a motor with inductance needs its speed", key=f"joints.{name}.actuator", remedy=remedy
            )
        dt, x = np.diff(recording.t), recording[seen]
        columns[f"tau.{name}"] = _asked(
            actuator, model.joints[name].gear_ratio, recording[f"tau.{name}"], np.diff(x) / dt, dt
        )
    return with_channels(recording, columns) if columns else recording


def _asked(actuator: Actuator, ratio: float, tau: Array, omega: Array, dt: Array) -> Array:
    """Torque at standstill (samples,) of the voltage that gives the same current without inductance."""
    motor, per_volt = actuator.dc_motor, actuator.per_volt(ratio)
    kt = ratio * motor.torque_constant
    lost = kt * omega / motor.resistance  # [A], of the back-EMF
    volts = np.clip(tau[:-1] / per_volt, -motor.supply, motor.supply)
    wanted = volts / motor.resistance - lost
    lag = motor.inductance / motor.resistance
    kept = np.exp(-dt / lag)
    # `winding_end` and `winding_mean` of laws.hpp, as currents.
    mean, now = np.empty(len(dt)), float(np.clip(wanted[0], -motor.current_limit, motor.current_limit))
    for k, (target, share) in enumerate(zip(wanted.tolist(), (lag / dt * (1.0 - kept)).tolist(), strict=True)):
        mean[k] = target + (now - target) * share
        now = float(np.clip(target + (now - target) * kept[k], -motor.current_limit, motor.current_limit))
    asked = per_volt * motor.resistance * (np.clip(mean, -motor.current_limit, motor.current_limit) + lost)
    return np.append(asked, asked[-1])


def _windings(model: FlexibleJointModel) -> dict[str, Actuator]:
    """Actuators of the motors with inductance, by joint."""
    drives = {name: joint.actuator for name, joint in model.joints.items()}
    return {name: each for name, each in drives.items() if each is not None and each.dc_motor.inductance > 0.0}
