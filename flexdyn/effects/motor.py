"""The laws of a DC motor under voltage, made of a joint's actuator: no candidates and no entries of a model file."""

from __future__ import annotations

import math
from typing import ClassVar

from flexdyn.effects.base import JointEffect, parameter


class MotorLaw(JointEffect, abstract=True):
    """What a joint's actuator does to the torque asked for; the model makes it of the actuator's numbers.

    The torque asked of a motor under voltage is the one that the voltage would give at standstill, ``tau = kt V/R``.
    It is a number of N m or N like any other, held as the voltage is.
    """

    name: ClassVar[str] = "motor_law"
    sides = ("motor",)
    stage = "actuator"
    order = 0


class SupplyLimit(MotorLaw, abstract=True):
    """A driver gives no more than its supply: the torque at standstill is cut at that of the full voltage.

    Args:
        joint: its name.
        limit: torque at standstill under the full supply [N m]; infinite: none.
    """

    name = "supply_limit"
    law = "clip(tau, -limit, limit)"
    neutral = {"limit": math.inf}

    limit: float = parameter("N m", lower=0.0, strict=True)


class MotorTorque(MotorLaw, abstract=True):
    """The torque of a DC motor: less by its back-EMF the faster it turns, and cut where its current is limited.

    ``tau_applied = clip(gain tau - back_emf omega, -limit, limit)``, ``back_emf = kt^2/R``, ``limit = kt i_max``.

    Args:
        joint: its name.
        gain: torque at standstill over what the model file's numbers make of the voltage [1].
        back_emf: [N m s/rad].
        limit: at the largest current [N m]; infinite: no limit.
    """

    name = "dc_motor"
    law = "clip(gain*tau - back_emf*omega, -limit, limit)"

    gain: float = parameter("1")
    back_emf: float = parameter("N m s/rad", lower=0.0)
    limit: float = parameter("N m", lower=0.0, strict=True, infinite=True)


class MotorWinding(MotorLaw, abstract=True):
    """The torque of a DC motor whose current takes time: ``L i' = V - R i - kt omega``.

    In torque, ``tau = k i``: ``time_constant tau' = gain tau_asked - back_emf omega - tau``. The driver holds the
    current at its limit while the voltage would raise it further. The torque is an internal state, 0 at the start.

    Args:
        joint: its name.
        gain: torque at standstill over what the model file's numbers make of the voltage [1].
        back_emf: [N m s/rad].
        limit: at the largest current [N m]; infinite: no limit.
        time_constant: L/R [s].
    """

    name = "dc_winding"
    law = "time_constant*tau_applied' = gain*tau - back_emf*omega - tau_applied, abs(tau_applied) <= limit"

    gain: float = parameter("1")
    back_emf: float = parameter("N m s/rad", lower=0.0, strict=True)
    limit: float = parameter("N m", lower=0.0, strict=True, infinite=True)
    time_constant: float = parameter("s", lower=0.0, strict=True)
