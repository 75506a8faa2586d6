"""A motion that is tried, and how far apart the hypotheses are for it."""

from __future__ import annotations

import contextlib
from dataclasses import dataclass, replace

import numpy as np

from flexdyn.diagnose.experiment.bench import RehearsalBench, Side
from flexdyn.diagnose.experiment.moves import PlannedMotion
from flexdyn.errors import InputError

CLEAR_DELTA_BIC = 50.0
"""Two laws are separated if the expected delta BIC is at least this [1]."""
LONGEST_MOTION = 120.0
"""Longest time for which a motion is repeated [s]."""


@dataclass(frozen=True, eq=False)
class Rehearsal:
    """A motion, and the differences of the hypotheses for it.

    Attributes:
        bench: on which it was tried, with the payload of the motion.
        move: the motion.
        sides: simulated with the named hypothesis, then, if needed, with each of its rivals.
    """

    bench: RehearsalBench
    move: PlannedMotion
    sides: tuple[Side, ...]

    @classmethod
    def of(cls, bench: RehearsalBench, move: PlannedMotion) -> Rehearsal:
        """The motion simulated with the named hypothesis, evaluated by the equations.

        Raises:
            InputError: it exceeds the motions in the recordings.
            SimulationError: it cannot be simulated.
        """
        bench = bench.loaded(move.mass)
        return cls(bench, move, (bench.side(0, move),))

    @property
    def seconds(self) -> float:
        """Duration of one pass [s]."""
        return (len(self.move.path) - 1) * self.bench.reach.dt

    @property
    def most(self) -> int:
        """How often the motion may be repeated."""
        return max(1, int(LONGEST_MOTION / self.seconds))

    @property
    def worth(self) -> float:
        """Sum of squares of one pass below which no repetition separates the hypotheses."""
        return CLEAR_DELTA_BIC / self.most

    @property
    def passes(self) -> int | None:
        """How often it must be repeated to separate the hypotheses; None: it does not help."""
        return next((count for count in range(1, self.most + 1) if self.apart(count) >= CLEAR_DELTA_BIC), None)

    def apart(self, passes: int = 1) -> float:
        """Expected delta BIC of the right hypothesis to the nearest other one, if the motion is repeated."""
        return min(min(side.apart(passes)) for side in self.sides)

    @property
    def reversals(self) -> int:
        """Number of reversals of the joint."""
        way = np.sign(np.round(np.diff(self.sides[0].run.theta[:, self.move.joint]), 9))
        way = way[way != 0.0]
        return int((way[1:] != way[:-1]).sum())

    def with_windows(self) -> Rehearsal:
        """The same, also evaluated by simulated windows."""
        return replace(self, sides=tuple(self.bench.with_windows(side, self.worth) for side in self.sides))

    def from_all_sides(self) -> Rehearsal:
        """A motion that separates the rivals, simulated with each of them too; another motion as it is.

        A rival that would make the arm leave what it has been seen to do is left out: the arm itself would show that.

        Raises:
            SimulationError: it cannot be simulated.
        """
        if self.apart(self.most) < CLEAR_DELTA_BIC:
            return self
        sides = list(self.sides[:1])
        for k in range(1, len(self.bench.known)):
            with contextlib.suppress(InputError):
                side = self.bench.side(k, self.move)
                sides.append(self.bench.with_windows(side, self.worth) if sides[0].by_windows else side)
        return replace(self, sides=tuple(sides))
