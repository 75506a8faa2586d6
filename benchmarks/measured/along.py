"""An inverse model along a measured motion: the torque that it needs, and what is missing to the measured one."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

import flexdyn as fd
from flexdyn.diagnose.data.filters import Filters
from flexdyn.diagnose.data.measured import measured
from flexdyn.diagnose.equations.equations import Equations

Array = NDArray[np.float64]
MOVING = 5e-3
"""Speed above which a joint slides for certain [rad/s]; below it friction may be anything between its levels."""


@dataclass(frozen=True, eq=False)
class Inverse:
    """An inverse model along a record, every term behind the same filters.

    Attributes:
        t: times (rows,) [s].
        q, omega: positions and velocities of the motors, reflected (rows, n) [rad, rad/s].
        torque: of the motors, reflected (rows, n) [N m].
        missing: what the model lacks: torque - model (rows, n) [N m].
    """

    t: Array
    q: Array
    omega: Array
    torque: Array
    missing: Array

    def error(self, j: int, left: Array | None = None, moving: bool = False) -> float:
        """Root mean square of what is left of a joint's torque over that of the torque itself [1]."""
        rows = np.abs(self.omega[:, j]) > MOVING if moving else np.ones(len(self.t), dtype=bool)
        rest = (self.missing[:, j] if left is None else left)[rows]
        return float(np.linalg.norm(rest) / np.linalg.norm(self.torque[rows, j]))


def along(model: fd.FlexibleJointModel, recording: fd.Recording) -> Inverse:
    """A model along the motion of a recording."""
    data = measured(model, recording)
    filters = Filters.of_rate(data.dt)
    equations = Equations(model, (data,), filters)
    motion = equations.motions[0]
    missing = equations.residual.reshape(-1, len(equations.kinds))
    theta, omega, tau = (filters.rows(each) for each in (motion.theta, motion.omega, motion.tau))
    return Inverse(motion.t[filters.instants(len(motion.t))], theta, omega, tau, missing)
