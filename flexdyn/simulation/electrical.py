"""Volts, amperes and heat of the motors of a run."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from flexdyn.arrays import Array
from flexdyn.effects import MemoryEffect
from flexdyn.effects.motor import MotorWinding
from flexdyn.model.flexible_joint_model import FlexibleJointModel
from flexdyn.simulation.plant import acting_effects

ROUNDING = 1e-12
"""Part of a limit that a current at it may be off."""


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
    kept = [effect for effect in acting_effects(model) if isinstance(effect, MemoryEffect | MotorWinding)]
    return {effect.joint: place for place, effect in enumerate(kept) if isinstance(effect, MotorWinding)}
