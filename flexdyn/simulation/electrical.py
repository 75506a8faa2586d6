"""Volts, amperes and heat of the motors of a run."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from flexdyn.model.flexible_joint_model import FlexibleJointModel

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Electrical:
    """Electrical quantities of every joint's motor at the samples (samples, n); NaN where a joint has no DC motor.

    Attributes:
        voltage: at the motor's terminals [V]: as asked for, but where the supply or the current's limit cuts it.
        current: [A].
        power: voltage times current [W]; the rest of it beside `heat` is mechanical.
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


def electrical(model: FlexibleJointModel, tau: Array, omega: Array) -> Electrical:
    """Of motors that are asked for torques while they turn.

    Args:
        model: that has the actuators.
        tau: commanded torques (samples, n) [N m or N].
        omega: rotor speeds, reflected (samples, n).
    """
    volts, true = asked_voltage(model, tau), model.resolved()
    current, heat = np.full_like(tau, np.nan), np.full_like(tau, np.nan)
    for j, joint in enumerate(true.joints.values()):
        if joint.actuator is None:
            continue
        motor = joint.actuator.dc_motor
        induced = joint.gear_ratio * motor.torque_constant * omega[:, j]
        free = (volts[:, j] - induced) / motor.resistance
        current[:, j] = np.clip(free, -motor.current_limit, motor.current_limit)
        heat[:, j] = motor.resistance * current[:, j] ** 2
        volts[:, j] = motor.resistance * current[:, j] + induced
    return Electrical(volts, current, volts * current, heat)
