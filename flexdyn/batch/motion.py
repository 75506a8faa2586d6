"""A run as metrics look at it: what several of them need is computed once."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from flexdyn.batch.aim import Aim
from flexdyn.batch.tip import tip_path
from flexdyn.run import Run

Array = NDArray[np.float64]
TAIL = 0.1
"""Share of the time after the command's rest that counts as the end: positions are averaged there."""
LEAST = 10
"""Samples that are needed after the command's rest."""


@dataclass(frozen=True, eq=False)
class Motion:
    """A run, its command's aim, and the tip's path.

    Attributes:
        run: the motion.
        aim: of its command.
    """

    run: Run
    aim: Aim

    @cached_property
    def tip(self) -> Array:
        """The tip at q (samples, 3) [m]."""
        return tip_path(self.run.model.robot, self.run.q)

    @cached_property
    def deflection(self) -> Array:
        """From where the tip would be if the links stood at the rotors' angles to where it is (samples, 3) [m]."""
        return self.tip - tip_path(self.run.model.robot, self.run.theta)

    @cached_property
    def tracking_error(self) -> Array:
        """Distance of the tip from where the reference would have it (samples,) [m]."""
        return _lengths(self.tip - tip_path(self.run.model.robot, self.aim.wanted(self.run.t)))

    @cached_property
    def resting(self) -> slice:
        """Samples from the command's rest on.

        Raises:
            ValueError: there are too few.
        """
        rest = self.aim.rest
        first = len(self.run.t) if rest is None else int(np.searchsorted(self.run.t, rest))
        if len(self.run.t) - first < LEAST:
            raise ValueError("the command does not come to rest before the run ends")
        return slice(first, None)

    @cached_property
    def tail(self) -> slice:
        """Samples of the last tenth of the time after the command's rest."""
        t = self.run.t[self.resting]
        return slice(int(np.searchsorted(self.run.t, t[-1] - TAIL * (t[-1] - t[0]))), None)

    @cached_property
    def distance(self) -> Array:
        """Distance of the tip from where it ends (samples,) [m]."""
        return _lengths(self.tip - self.tip[self.tail].mean(axis=0))

    def root_mean_square(self, values: Array) -> float:
        """Over time, by the trapezoidal rule, of values (samples,)."""
        t = self.run.t
        squares = values**2
        return float(np.sqrt(np.dot(np.diff(t), 0.5 * (squares[1:] + squares[:-1])) / (t[-1] - t[0])))


def _lengths(vectors: Array) -> Array:
    return np.asarray(np.sqrt(np.einsum("ij,ij->i", vectors, vectors)))
