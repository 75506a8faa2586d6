"""Effects between the torque asked for (tau) and the torque on the rotor (tau_applied)."""

from __future__ import annotations

import math

from flexdyn.effects.base import JointEffect, parameter


class TorqueOffset(JointEffect):
    """A constant torque that nobody asked for: current sensor offset, cogging bias.

    ``tau_applied = tau + offset``.

    Args:
        joint: its name.
        offset: [N m].
    """

    sides = ("motor",)
    stage = "actuator"
    law = "tau + offset"
    neutral = {"offset": 0.0}

    offset: float = parameter("N m")


class TorqueSpeedLimit(JointEffect):
    """The torque-speed line of a motor: what it can give falls to nothing at the no-load speed.

    ``tau`` clipped to ``[-stall (1 + omega/no_load), stall (1 - omega/no_load)]``, neither bound past zero. Paper,
    Table I: stall torque 0.63 N m, no-load speed 3.5 rad/s; its "actuator constants" k_1 = 0.63 and k_2 = 0.18 =
    0.63/3.5 are this line.

    Args:
        joint: its name.
        stall_torque: at omega = 0 [N m]; infinite: no limit.
        no_load_speed: where the torque is gone [rad/s].
    """

    sides = ("motor",)
    stage = "actuator"
    law = "clip(tau, -stall_torque*(1 + omega/no_load_speed), stall_torque*(1 - omega/no_load_speed))"
    neutral = {"stall_torque": math.inf}

    stall_torque: float = parameter("N m", lower=0.0)
    no_load_speed: float = parameter("rad/s", lower=0.0, strict=True)
