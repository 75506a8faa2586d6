"""Effects between the commanded torque (tau) and the torque on the rotor (tau_applied)."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence

from flexdyn.effects.extent import DELAYS, SLOW_HARMONICS, MotionExtent
from flexdyn.effects.joint_effect import JointEffect
from flexdyn.effects.parameters import parameter, spaced
from flexdyn.effects.waves import WaveEffect


class ActuatorEffect(JointEffect, abstract=True):
    """An effect on the torque of a joint's motor."""

    sides = ("motor",)


class TorqueOffset(ActuatorEffect):
    """A constant torque that was not commanded: current sensor offset, cogging bias.

    ``tau_applied = tau + offset``.

    Args:
        joint: its name.
        offset: [N m].
    """

    law = "tau + offset"
    shown = {"offset": 0.3}
    order = 2
    linear = ("offset",)
    is_constant = True
    regressed = "offset"

    offset: float = parameter("N m")


class TorqueConstantError(ActuatorEffect):
    """The motor gives a constant factor of the commanded torque: its torque constant is not the assumed one.

    ``tau_applied = (1 + gain) tau``. Several on one joint add their gains.

    Args:
        joint: its name.
        gain: 0.05 means five percent more; -2 means that the motor is wired the wrong way round [1].
    """

    law = "(1 + gain)*tau"
    shown = {"gain": 0.2}
    order = 1
    linear = ("gain",)
    scales_torque = "gain"
    natural_size = 0.15

    gain: float = parameter("1")


class TorqueRipple(WaveEffect, ActuatorEffect):
    """Torque that varies with the rotor's angle: cogging, slots, uneven phase currents.

    ``tau_applied = tau + amplitude sin(harmonic theta + phase)``.

    Args:
        joint: its name.
        amplitude: [N m].
        harmonic: cycles per reflected turn; once per motor turn is the gear ratio [1], of a prismatic joint [rad/m].
        phase: [rad].
    """

    law = "tau + amplitude*sin(harmonic*theta + phase)"
    shown = {"amplitude": 0.3, "harmonic": 2.0, "phase": 0.0}
    order = 3

    amplitude: float = parameter("N m")

    @classmethod
    def tried(cls, extent: MotionExtent) -> Iterable[Sequence[float]]:
        """See the base class."""
        return extent.waves(SLOW_HARMONICS if extent.turns else (), (1.0, 2.0, 3.0, 6.0))

    @classmethod
    def small(cls, extent: MotionExtent) -> float:
        """See the base class."""
        return extent.torque


class TorqueSpeedLimit(ActuatorEffect):
    """The torque-speed line of a motor: the largest torque falls to zero at the no-load speed.

    ``tau`` clipped to ``[-stall (1 + omega/no_load), stall (1 - omega/no_load)]``, neither bound past zero. Paper,
    Table I: stall torque 0.63 N m, no-load speed 3.5 rad/s; its "actuator constants" k_1 = 0.63 and k_2 = 0.18 =
    0.63/3.5 are this line.

    Args:
        joint: its name.
        stall_torque: at omega = 0 [N m]; infinite: no limit.
        no_load_speed: speed at which the largest torque is zero [rad/s].
    """

    law = "clip(tau, -stall_torque*(1 + omega/no_load_speed), stall_torque*(1 - omega/no_load_speed))"
    neutral = {"stall_torque": math.inf}
    shown = {"stall_torque": 1.0, "no_load_speed": 3.0}
    order = 5
    cuts_torque = True
    keeps_to = "effort"
    grids = {  # of the applied torque: a controller may command many times the limit
        "stall_torque": ("given", (0.45, 0.6, 0.75, 0.9, 1.2, 1.6, 2.2, 3.0)),
        "no_load_speed": ("speed", (1.1, 1.5, 2.0, 3.0, 10.0)),
    }
    of_recorded_torque = True

    stall_torque: float = parameter("N m", lower=0.0, by_factor=True)
    no_load_speed: float = parameter("rad/s", lower=0.0, strict=True)


class TorqueSaturation(ActuatorEffect):
    """Torque that is lost at high current: the iron saturates, and more current gives less additional torque.

    ``tau_applied = tau/(1 + abs(tau)/scale)``: half of the commanded torque is lost at ``abs(tau) = scale``, and no
    torque reaches the scale. Of a small torque the share ``abs(tau)/scale`` is lost, to first order. The slope is
    continuous.

    It acts after gain, offset and ripple, because the whole current magnetises the iron. The torque-speed line acts
    after it, because it limits the torque that the motor gives. Source: the fall of the torque
    constant at high current in motors' data sheets; a saturation of the Froelich kind, ``B = H/(a + b H)``.

    Args:
        joint: its name.
        scale: torque that is never reached [N m]; infinite: no loss.
    """

    law = "tau/(1 + abs(tau)/scale)"
    neutral = {"scale": math.inf}
    shown = {"scale": 2.0}
    order = 4
    grids = {"scale": ("given", spaced(0.7, 70.0, 13))}
    of_recorded_torque = True

    scale: float = parameter("N m", lower=0.0, strict=True)


class CommandDelay(ActuatorEffect):
    """The commanded torque arrives late: a bus, a control cycle.

    ``tau_applied(t) = tau(t - delay)``; 0 before the first command arrives. Several on one joint add.

    Args:
        joint: its name.
        delay: [s].
    """

    law = "tau(t - delay)"
    neutral = {"delay": 0.0}
    no_torque = "it shifts the command in time"
    shown = {"delay": 0.005}
    order = -1
    grids = {"delay": ("one", DELAYS)}
    prevalence = "often"
    late_by = "delay"

    delay: float = parameter("s", lower=0.0)
