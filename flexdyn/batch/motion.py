"""Many runs in the form for metrics: quantities that several metrics need are computed once."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Self

import numpy as np

from flexdyn.arrays import Array
from flexdyn.batch.aim import Aim
from flexdyn.robot import Robot, frame_positions
from flexdyn.simulation.inputs_and_signals import SIGNALS
from flexdyn.simulation.run import Run

TAIL = 0.1
"""Share of the time after the command's rest that counts as the end, where positions are averaged [1]."""
LEAST_SAMPLES_AFTER_REST = 10
"""Smallest number of samples after the command's rest."""


@dataclass(frozen=True, eq=False)
class RunsMotion:
    """Runs of one arm at the same times, the properties of their command, and the paths of the tip.

    The results for a run do not depend on the other runs, to the last bit.

    Attributes:
        robot: the arm.
        t: of the samples (samples,) [s].
        signals: (runs, samples, n) each, by name.
        aim: of their command.
        runs: the runs themselves, or none if no metric needs them.
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
        """Number of runs."""
        return len(self.signals["q"])

    @cached_property
    def tip(self) -> Array:
        """The tip at q (runs, samples, 3) [m]."""
        return frame_positions(self.robot, self.signals["q"])

    @cached_property
    def deflection(self) -> Array:
        """The position of the tip minus its position with the links at the rotors' angles (runs, samples, 3) [m]."""
        return self.tip - frame_positions(self.robot, self.signals["theta"])

    @cached_property
    def tracking_error(self) -> Array:
        """Distance of the tip from its position at the reference (runs, samples) [m]."""
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
        """Distance of the tip from its final position (runs, samples) [m]."""
        return lengths(self.tip - self.tip[:, self.tail].mean(axis=1, keepdims=True))

    def greatest(self, values: Array, joints: slice) -> Array:
        """The largest absolute value over time and some of the joints, of values (runs, samples, n)."""
        return np.asarray(np.abs(values[..., joints]).max(axis=(1, 2)))

    def root_mean_square(self, values: Array) -> Array:
        """Integral over time of values (runs, samples), by the trapezoidal rule."""
        return np.asarray(np.sqrt(np.trapezoid(values**2, self.t, axis=1) / (self.t[-1] - self.t[0])))


def lengths(vectors: Array) -> Array:
    """Lengths of vectors (..., 3)."""
    x, y, z = np.moveaxis(vectors**2, -1, 0)
    return np.asarray(np.sqrt(x + y + z))
