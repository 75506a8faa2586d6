"""Runs as metrics look at them, all at once: what several of them need is computed once."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Self

import numpy as np
from numpy.typing import NDArray

from flexdyn.batch.aim import Aim
from flexdyn.robot import Robot, frame_positions
from flexdyn.simulation.inputs_and_signals import SIGNALS
from flexdyn.simulation.run import Run

Array = NDArray[np.float64]
TAIL = 0.1
"""Share of the time after the command's rest that counts as the end: positions are averaged there."""
LEAST_SAMPLES_AFTER_REST = 10
"""Samples that are needed after the command's rest."""


@dataclass(frozen=True, eq=False)
class RunsMotion:
    """Runs of one arm over the same samples, their command's aim, and the tip's paths.

    Whatever is computed of a run is the same to the last bit, whichever others it is looked at with.

    Attributes:
        robot: the arm.
        t: of the samples (samples,) [s].
        signals: (runs, samples, n) each, by name.
        aim: of their command.
        runs: themselves, or none where nobody asks for them.
    """

    robot: Robot
    t: Array
    signals: Mapping[str, Array]
    aim: Aim
    runs: Sequence[Run] = ()

    @classmethod
    def of(cls, run: Run, aim: Aim) -> Self:
        """A single run."""
        signals = {signal: getattr(run, signal)[None] for signal in SIGNALS}
        return cls(run.model.robot, run.t, signals, aim, (run,))

    @property
    def count(self) -> int:
        """How many runs there are."""
        return len(self.signals["q"])

    @cached_property
    def tip(self) -> Array:
        """The tip at q (runs, samples, 3) [m]."""
        return frame_positions(self.robot, self.signals["q"])

    @cached_property
    def deflection(self) -> Array:
        """From the tip's place if the links stood at the rotors' angles to where it is (runs, samples, 3) [m]."""
        return self.tip - frame_positions(self.robot, self.signals["theta"])

    @cached_property
    def tracking_error(self) -> Array:
        """Distance of the tip from where the reference would have it (runs, samples) [m]."""
        return lengths(self.tip - frame_positions(self.robot, self.aim.wanted(self.t)))

    @cached_property
    def resting(self) -> slice:
        """Samples from the command's rest on.

        Raises:
            ValueError: there are too few.
        """
        rest = self.aim.rest
        first = len(self.t) if rest is None else int(np.searchsorted(self.t, rest))
        if len(self.t) - first < LEAST_SAMPLES_AFTER_REST:
            raise ValueError("the command does not come to rest before the run ends")
        return slice(first, None)

    @cached_property
    def tail(self) -> slice:
        """Samples of the last tenth of the time after the command's rest."""
        t = self.t[self.resting]
        return slice(int(np.searchsorted(self.t, t[-1] - TAIL * (t[-1] - t[0]))), None)

    @cached_property
    def distance(self) -> Array:
        """Distance of the tip from where it ends (runs, samples) [m]."""
        return lengths(self.tip - self.tip[:, self.tail].mean(axis=1, keepdims=True))

    def greatest(self, values: Array, joints: slice) -> Array:
        """The greatest size over time and some of the joints of values (runs, samples, n)."""
        return np.asarray(np.abs(values[..., joints]).max(axis=(1, 2)))

    def root_mean_square(self, values: Array) -> Array:
        """Over time, by the trapezoidal rule, of values (runs, samples)."""
        squares = values**2
        areas = np.diff(self.t) * (0.5 * (squares[:, 1:] + squares[:, :-1]))
        return np.asarray(np.sqrt(areas.sum(axis=1) / (self.t[-1] - self.t[0])))


def lengths(vectors: Array) -> Array:
    """Of vectors (..., 3)."""
    x, y, z = np.moveaxis(vectors**2, -1, 0)
    return np.asarray(np.sqrt(x + y + z))
