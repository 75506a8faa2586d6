"""What goes into a run, and the signals that come out of it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from flexdyn.control.commands import FrameWrench, Samples

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
    """

    x0: Array
    samples: Samples | None
    external: tuple[FrameWrench, ...]
    duration: float
