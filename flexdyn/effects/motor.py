"""The laws of a DC motor under voltage, made from the actuator; they are no candidates and not in a model file."""

from __future__ import annotations

import math
from typing import ClassVar

from flexdyn.effects.actuator import ActuatorEffect
from flexdyn.effects.parameters import parameter


class MotorLaw(ActuatorEffect, abstract=True):
    """The effect of a joint's actuator on the commanded torque; the model makes it from the actuator's numbers.

    The commanded torque of a motor under voltage is the torque that the voltage gives at standstill, ``tau = kt V/R``.
    It is in N m or N, and is held between samples as the voltage is.
    """

    name: ClassVar[str] = "motor_law"
    order = 0


class SupplyLimit(MotorLaw, abstract=True):
    """The supply limits the voltage: the torque at standstill is at most that of the full voltage.

    Args:
        joint: its name.
        limit: torque at standstill under the full supply [N m]; infinite: none.
    """

    name = "supply_limit"
    law = "clip(tau, -limit, limit)"
    neutral = {"limit": math.inf}

    limit: float = parameter("N m", lower=0.0, strict=True)


class DCMotorLaw(MotorLaw, abstract=True):
    """The torque of a DC motor under voltage, of which the back-EMF takes a part.

    Args:
        joint: its name.
        gain: torque at standstill over the torque that the model file's numbers give for the voltage [1].
        back_emf: [N m s/rad].
        limit: at the largest current [N m]; infinite: no limit.
    """

    gain: float = parameter("1")
    back_emf: float = parameter("N m s/rad", lower=0.0)
    limit: float = parameter("N m", lower=0.0, strict=True, infinite=True)


class MotorTorque(DCMotorLaw, abstract=True):
    """The torque of a DC motor: the back-EMF reduces it with speed, and the current limit bounds it.

    ``tau_applied = clip(gain tau - back_emf omega, -limit, limit)``, ``back_emf = kt^2/R``, ``limit = kt i_max``.

    Args:
        joint: its name.
        gain: torque at standstill over the torque that the model file's numbers give for the voltage [1].
        back_emf: [N m s/rad].
        limit: at the largest current [N m]; infinite: no limit.
    """

    name = "dc_motor"
    law = "clip(gain*tau - back_emf*omega, -limit, limit)"


class MotorWinding(DCMotorLaw, abstract=True):
    """The torque of a DC motor whose current takes time: ``L i' = V - R i - kt omega``.

    In torque, ``tau = k i``: ``time_constant tau' = gain tau_asked - back_emf omega - tau``. The driver holds the
    current at its limit while the voltage would raise it further. The torque is an internal state, 0 at the start.

    Args:
        joint: its name.
        gain: torque at standstill over the torque that the model file's numbers give for the voltage [1].
        back_emf: [N m s/rad].
        limit: at the largest current [N m]; infinite: no limit.
        time_constant: L/R [s].
    """

    name = "dc_winding"
    law = "time_constant*tau_applied' = gain*tau - back_emf*omega - tau_applied, abs(tau_applied) <= limit"

    back_emf: float = parameter("N m s/rad", lower=0.0, strict=True)
    time_constant: float = parameter("s", lower=0.0, strict=True)
