"""What goes into a run, and the signals that come out of it."""

from __future__ import annotations

import pickle
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from flexdyn.control.commands import PD, Controller, FrameWrench, Samples
from flexdyn.control.servo import Servo

Array = NDArray[np.float64]
SIGNALS = ("q", "theta", "v", "omega", "tau", "tau_applied", "tau_s")


@dataclass(frozen=True, eq=False)
class Inputs:
    """What a run was made of, enough to make it again.

    Attributes:
        x0: first state [q, theta, v, omega, z].
        samples: torques over time; those a controller asked for stand here as it asked for them; None: none.
        external: wrenches.
        duration: [s].
        controller: that asked for the torques; None for torques over time. A law in Python that does not pickle, such
            as a lambda, stays behind where a run is pickled.
    """

    x0: Array
    samples: Samples | None
    external: tuple[FrameWrench, ...]
    duration: float
    controller: PD | Servo | Controller | None = None

    def __reduce__(self) -> tuple[Any, ...]:
        """Pickle without a controller that does not pickle."""
        controller = self.controller
        try:
            pickle.dumps(controller)
        except (pickle.PicklingError, AttributeError, TypeError):
            controller = None
        return (Inputs, (self.x0, self.samples, self.external, self.duration, controller))
