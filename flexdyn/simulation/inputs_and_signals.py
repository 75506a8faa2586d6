"""The inputs of a run, and its signals."""

from __future__ import annotations

import pickle
from dataclasses import dataclass
from typing import Any

from flexdyn.arrays import Array
from flexdyn.control.commands import PD, Controller, FrameWrench
from flexdyn.control.samples import Samples
from flexdyn.control.servo import Servo

SIGNALS = ("q", "theta", "v", "omega", "tau", "tau_applied", "tau_s")


@dataclass(frozen=True, eq=False)
class Inputs:
    """The inputs of a run, with which it can be repeated.

    Attributes:
        x0: first state [q, theta, v, omega, z].
        samples: commanded torques over time, those of a controller included; None: no torque.
        external: wrenches.
        duration: [s].
        controller: that commanded the torques; None for torques over time. If a run is pickled and its law cannot be,
            such as a lambda, the law is left out.
    """

    x0: Array
    samples: Samples | None
    external: tuple[FrameWrench, ...]
    duration: float
    controller: PD | Servo | Controller | None = None

    def __reduce__(self) -> tuple[Any, ...]:
        """Pickle without a controller that cannot be pickled."""
        controller = self.controller
        try:
            pickle.dumps(controller)
        except (pickle.PicklingError, AttributeError, TypeError):
            controller = None
        return (Inputs, (self.x0, self.samples, self.external, self.duration, controller))
