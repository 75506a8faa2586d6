"""A hypothesis fitted to the equations."""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping
from dataclasses import dataclass, field

import numpy as np

from flexdyn.arrays import Array, Indices
from flexdyn.diagnose.equations.equations import Equations
from flexdyn.diagnose.hypothesis.hypothesis import Hypothesis
from flexdyn.diagnose.hypothesis.regression import Regression
from flexdyn.diagnose.hypothesis.workspace import Workspace
from flexdyn.diagnose.lazy import lazy
from flexdyn.effects import Effect
from flexdyn.model.uncertain_parameters import FileNumber

CORRELATION_BLOCK = 0.5
"""Length of the blocks within which rows may be correlated [s]."""


@dataclass(frozen=True, eq=False)
class Fit:
    """A fitted hypothesis.

    Attributes:
        hypothesis: with its best numbers.
        equations: of its model.
        regression: at the last step; its columns are the file's numbers, then the effects' unknowns.
        space: in which it was fitted.
        scales: of the effects' unknowns.
        held: columns of unknowns at a bound that would leave it.
        free: the problem without these constraints, for standard deviations; None: no unknown is held.
        taken: hypothesis at which the slopes of the file's numbers were computed; None: at this one.
        block: number of correlated rows; 0: those of half a second of the equations.
        stationary: whether shares of the last step were tried without enough decrease.
    """

    hypothesis: Hypothesis
    equations: Equations
    regression: Regression
    space: Workspace
    scales: tuple[float, ...] = field(default=())
    held: tuple[int, ...] = ()
    free: Regression | None = None
    taken: Hypothesis | None = None
    block: int = 0
    stationary: bool = False

    @property
    def chi2(self) -> float:
        """Sum of squares of white rows and priors that the last linear problem predicts."""
        return self.regression.chi2

    @property
    def reached(self) -> float:
        """The same at the hypothesis itself; the two differ if the fit has not converged."""
        return self.regression.at_zero

    @property
    def reduced(self) -> float:
        """Mean square of the white rows: 1 if only noise is left."""
        return self.regression.data_chi2 / self.regression.rows

    @property
    def step(self) -> Array:
        """The step to the minimum of the last linear problem, with the offsets of the encoders (columns,)."""
        step = self.regression.values.copy()
        step[list(self.held)] = 0.0
        return step

    def std(self) -> dict[tuple[Effect, str], float]:
        """Standard deviations of the effects' unknowns."""
        first = len(self.hypothesis.factors)
        sigma = self._spread[first : first + len(self.scales)]
        keys = self.hypothesis.unknowns()
        return {key: float(s) * scale for key, s, scale in zip(keys, sigma, self.scales, strict=True)}

    def deviation(self, changes: Mapping[tuple[Effect, str], float]) -> float:
        """Standard deviations by which unknowns differ from other values together: ``sqrt(x^T C^-1 x)`` [1].

        Args:
            changes: differences x of some unknowns of the effects from these values.
        """
        keys = self.hypothesis.unknowns()
        places = self._places(changes)
        x = np.array([change / self.scales[keys.index(key)] for key, change in changes.items()])
        if not np.isfinite(x).all():
            return math.inf  # a stiffness differs from that of a rigid joint
        there = np.diag(self.regression.covariance)[places] > 0.0  # no row sees the others
        places, x = places[there], x[there]
        wider = self._widened(places)
        C = self.regression.covariance[np.ix_(places, places)] * np.outer(wider, wider)
        return float(np.sqrt(max(x @ np.linalg.lstsq(C, x, rcond=1e-12)[0], 0.0)))

    def widened(self, unknowns: Collection[tuple[Effect, str]]) -> float:
        """How many times correlated rows widen the standard deviations of some unknowns of the effects, at most [1]."""
        return float(self._widened(self._places(unknowns)).max(initial=1.0))

    def _places(self, unknowns: Collection[tuple[Effect, str]]) -> Indices:
        """Columns of some unknowns of the effects."""
        first, keys = len(self.hypothesis.factors), self.hypothesis.unknowns()
        return np.array([first + keys.index(key) for key in unknowns], np.intp)

    def _widened(self, places: Indices) -> Array:
        return np.asarray(
            self._spread[places] / np.sqrt(np.maximum(np.diag(self.regression.covariance)[places], 1e-300))
        )

    def factor_std(self) -> dict[FileNumber, float]:
        """Standard deviations of the file's numbers' factors."""
        return {number: float(s) for number, s in zip(self.hypothesis.factors, self._spread, strict=False)}

    @lazy
    def _spread(self) -> Array:
        """Standard deviations of all columns: the larger one of those for white rows and of the sandwich estimate.

        If more than noise is left, the filters cause an additional error of the numbers, as large as that of the rows.
        """
        spread = self._spread_of(self.regression)
        if self.free is not None:
            spread[list(self.held)] = self._spread_of(self.free)[list(self.held)]
        return spread

    def _spread_of(self, regression: Regression) -> Array:
        seconds = self.equations.filters.every * self.equations.data[0].dt
        block = self.block or max(1, round(CORRELATION_BLOCK / seconds)) * len(self.equations.kinds)
        both = (regression.covariance, regression.sandwich(block))
        return np.asarray(np.sqrt(max(1.0, self.reduced) * np.maximum(*(np.diag(each) for each in both))))
