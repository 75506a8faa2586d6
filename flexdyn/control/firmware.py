"""Firmware: the position controller that runs inside a servo, in counts of its encoder and of its PWM."""

from __future__ import annotations

import math
from dataclasses import dataclass, fields

from flexdyn.checks import number


@dataclass(frozen=True, kw_only=True)
class Firmware:
    """The position controller in the firmware of a hobby or smart servo: from position error in counts to PWM.

    At every tick ``e`` is the goal minus the position, both in whole counts, and 0 inside the dead band;
    ``pwm = kp e + ki sum(e)/rate + kd (e - e_before) rate``, limited and rounded towards 0. The sum does not change
    while the PWM is at its limit. A duty of 1 is `full_pwm`.

    Args:
        kp: PWM counts per position count [1].
        ki: PWM counts per position count and second [1/s].
        kd: PWM counts per position count per second [s].
        counts_per_turn: of the position, behind the gear.
        full_pwm: PWM counts that apply the whole supply to the motor.
        pwm_limit: limit of the controller's output; default: `full_pwm`.
        dead_band: errors of up to so many position counts are taken as 0.
        rate: of the controller [Hz].

    Raises:
        InputError: a number that is not allowed.

    Example:
        >>> firmware = fd.Firmware(kp=400 / 256, counts_per_turn=4096, full_pwm=885)
        >>> drive = {"gear_ratio": 50, "actuator": {"dc_motor": dict(torque_constant=0.01, resistance=2.0, supply=12)}}
        >>> model = fd.load_model("scara_two_link").replace(joints={"*": drive}, effects=[])
        >>> goal = fd.Samples([0.0, 1.0], {"shoulder": [0.4, 0.4], "elbow": [0.2, 0.2]})
        >>> run = fd.simulate(model, fd.Servo(reference=goal, firmware=firmware), duration=0.1, q0=[0.0, 0.0])
        >>> run.electrical.voltage[0]  # errors of 261 and 130 counts give 407 and 203 PWM counts
        array([5.51864407, 2.75254237])
    """

    kp: float
    counts_per_turn: float
    full_pwm: float
    ki: float = 0.0
    kd: float = 0.0
    pwm_limit: float = math.inf
    dead_band: float = 0.0
    rate: float = 1000.0

    def __post_init__(self) -> None:
        """Check every number."""
        for field in fields(self):
            name, value, infinite = field.name, getattr(self, field.name), field.name == "pwm_limit"
            if name in ("counts_per_turn", "full_pwm", "pwm_limit", "rate"):
                checked = number(name, value, "a finite number above 0 is needed", above=0.0, infinite=infinite)
            else:
                checked = number(name, value, "a finite number of at least 0 is needed", least=0.0)
            object.__setattr__(self, name, checked)
        object.__setattr__(self, "pwm_limit", min(self.pwm_limit, self.full_pwm))

    @property
    def numbers(self) -> tuple[float, ...]:
        """The settings in the form that the core takes."""
        return tuple(getattr(self, key) for key in CORE_ORDER)


CORE_ORDER = ("kp", "ki", "kd", "counts_per_turn", "full_pwm", "pwm_limit", "dead_band", "rate")
