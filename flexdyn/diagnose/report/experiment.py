"""The motion that would separate a finding from its rivals."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from flexdyn.control.commands import PD
from flexdyn.io.locked import Locked, locked_copy


@dataclass(frozen=True, eq=False)
class Experiment(Locked):
    """A motion that was shown by simulation to tell a finding from its rivals.

    Attributes:
        motion: what to do, in words.
        seconds: its duration with repetitions [s].
        passes: number of repetitions.
        payload: known mass to be added at the tip [kg].
        delta_bic: expected delta BIC of the right name to the nearest other one, for any of them being right.
        command: of the simulation: joint control along one pass of the motion.
        names: of the finding and of its nearest rival.
        t: times (points,) [s].
        position: of the moving joint (points,) [rad or m].
        left: residual of the rival with fitted numbers, if the finding is right (points,).
        noise: standard deviation of `left` (points,).
        labels: of position and residual, with their units.
    """

    motion: str
    seconds: float
    passes: int
    payload: float
    delta_bic: float
    command: PD
    names: tuple[str, str]
    t: NDArray[np.float64]
    position: NDArray[np.float64]
    left: NDArray[np.float64]
    noise: NDArray[np.float64]
    labels: tuple[str, str]

    def __post_init__(self) -> None:
        """Copy the arrays and make them read-only."""
        for name in ("t", "position", "left", "noise"):
            object.__setattr__(self, name, locked_copy(getattr(self, name)))

    @property
    def apart(self) -> float:
        """Difference between the names in units of the noise: the root of the expected delta BIC."""
        return math.sqrt(self.delta_bic)
