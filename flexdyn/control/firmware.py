"""Firmware: the position controller that runs inside a servo, in counts of its encoder and of its PWM."""

from __future__ import annotations

import math
from dataclasses import dataclass, fields

import numpy as np
from numpy.typing import ArrayLike, NDArray

from flexdyn.checks import as_number
from flexdyn.errors import InputError

Array = NDArray[np.float64]


@dataclass(frozen=True, kw_only=True)
class Firmware:
    """Position error in counts to PWM, as the firmware of a hobby or smart servo computes it.

    At every tick ``e`` is the goal less the position, both in whole counts, 0 inside the dead band;
    ``pwm = kp e + ki sum(e)/rate + kd (e - e_before) rate``, cut at the limit and rounded towards 0. The sum stands
    still while the PWM is cut. A duty of 1 is `full_pwm`.

    Args:
        kp: PWM counts per position count [1].
        ki: PWM counts per position count and second [1/s].
        kd: PWM counts per position count per second [s].
        counts_per_turn: of the position, behind the gear.
        full_pwm: PWM counts that put the whole supply on the motor.
        pwm_limit: at which the controller cuts its output; default: `full_pwm`.
        dead_band: position counts of error that are taken for none.
        rate: of the controller [Hz].

    Raises:
        InputError: a number that makes no sense.

    Example:
        >>> firmware = fd.Firmware(kp=400 / 256, counts_per_turn=4096, full_pwm=885)
        >>> firmware.duty([0.1, 1.0], [0.0, 0.0])  # of a goal of 0.1 rad, then 1 rad, held at 0
        array([0.11412429, 1.        ])
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
            number = as_number(getattr(self, field.name))
            above = field.name in ("counts_per_turn", "full_pwm", "pwm_limit", "rate")
            sense = number > 0.0 if above else number >= 0.0
            if not sense or (math.isinf(number) and field.name != "pwm_limit"):
                bound = "above 0" if above else "of at least 0"
                value = getattr(self, field.name)
                raise InputError(f"a finite number {bound} is needed", key=field.name, value=value)
            object.__setattr__(self, field.name, number)
        object.__setattr__(self, "pwm_limit", min(self.pwm_limit, self.full_pwm))

    def duty(self, goal: ArrayLike, position: ArrayLike) -> Array:
        """Duty at each tick (ticks,) [1], from rest.

        Args:
            goal: at the ticks (ticks,) [rad].
            position: likewise.
        """
        controller = Ticks(self)
        return np.array([controller.duty(*each) for each in zip(np.asarray(goal), np.asarray(position), strict=True)])


class Ticks:
    """The firmware of one run: it remembers its sum and its last error.

    Args:
        firmware: its settings.
    """

    def __init__(self, firmware: Firmware) -> None:
        self._set = firmware
        self._counts = firmware.counts_per_turn / math.tau
        self._sum = 0.0
        self._before: float | None = None

    def duty(self, goal: float, position: float) -> float:
        """Duty [1] at the next tick, of a goal and a position [rad]."""
        own = self._set
        error = float(round(goal * self._counts) - round(position * self._counts))
        if abs(error) <= own.dead_band:
            error = 0.0
        rise = 0.0 if self._before is None else (error - self._before) * own.rate
        self._before = error
        summed = self._sum + error / own.rate
        pwm = own.kp * error + own.ki * summed + own.kd * rise
        if abs(pwm) > own.pwm_limit:
            pwm = math.copysign(own.pwm_limit, pwm)
        else:
            self._sum = summed
        return math.trunc(pwm) / own.full_pwm
