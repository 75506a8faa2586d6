"""A short fit near another one that keeps its slopes: a step takes one evaluation of the equations, and no slopes."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass

import numpy as np

from flexdyn.arrays import Array
from flexdyn.diagnose.hypothesis.estimate import SHORTENED_STEP
from flexdyn.diagnose.hypothesis.fitted import Fit
from flexdyn.diagnose.hypothesis.hypothesis import Hypothesis, moved
from flexdyn.diagnose.hypothesis.linear import problem_of, scales_of, tangent
from flexdyn.diagnose.hypothesis.workspace import Workspace
from flexdyn.diagnose.parallel import SILENT
from flexdyn.errors import SimulationError

CHORD_STEPS = 2
"""Steps with the same slopes, at most."""


@dataclass(frozen=True, eq=False)
class _Slopes:
    """Slopes and weights that do not change.

    Attributes:
        base: the fit whose slopes they are.
        space: with its weights.
        X: whitened derivatives by the numbers, the unknowns in their own units, and the nuisances (rows, columns).
    """

    base: Fit
    space: Workspace
    X: Array

    @classmethod
    def of(cls, base: Fit, start: Hypothesis) -> _Slopes:
        """Those of a fit, and of the unknowns that it does not have."""
        space = base.space.at(base.equations)
        regression = base.free or base.regression
        numbers = len(base.hypothesis.factors)
        first = regression.X.shape[1] - regression.nuisances
        units = zip(base.hypothesis.unknowns(), base.scales, strict=True)
        known = {key: regression.X[:, numbers + k] / scale for k, (key, scale) in enumerate(units)}
        unknowns = start.unknowns()
        if new := [key for key in unknowns if key not in known]:
            along = space.bare.sloping(base.space.equations.of(start.model()))
            with SILENT():
                made = [tangent(along, *key) for key in new]
            known |= dict(zip(new, space.whiten(np.stack(made, axis=1)).T, strict=True))
        by_unknown = np.stack([known[key] for key in unknowns], axis=1) if unknowns else regression.X[:, :0]
        return cls(base, space, np.hstack([regression.X[:, :numbers], by_unknown, regression.X[:, first:]]))

    def problem(self, there: Hypothesis) -> Fit:
        """The least-squares problem at a hypothesis with as many unknowns.

        Raises:
            SimulationError: the equations are not finite.
        """
        at = self.base.space.equations.of(there.model())
        scales = scales_of(there)
        units = np.ones(self.X.shape[1])
        units[len(there.factors) : len(units) - self.space.bare.unknown.shape[1]] = scales
        with SILENT():
            y = self.space.beside_nuisance(at.residual)[0][:, 0]
        made = problem_of(there, at, y, self.X * units, self.space, scales)
        return dataclasses.replace(made, space=self.base.space)  # whose weights follow the hypothesis


def chord_fit(start: Hypothesis, base: Fit) -> Fit:
    """Fit a hypothesis in a few steps with the slopes of another fit (the chord method; Kelley, 1995, chapter 5).

    Args:
        start: first values; numbers that are out of their tolerance are set back into it.
        base: a fit near it.

    Raises:
        SimulationError: the equations are not finite at the start.
    """
    start = start.tolerated()
    slopes = _Slopes.of(base, start)
    best = slopes.problem(start)
    share = 1.0
    for _ in range(CHORD_STEPS):
        try:
            made = slopes.problem(moved(best.hypothesis, share * best.step, best.scales))
        except SimulationError:  # too far
            share *= SHORTENED_STEP
            continue
        if made.reached < best.reached:
            best = made
        else:
            share *= SHORTENED_STEP
    return best
