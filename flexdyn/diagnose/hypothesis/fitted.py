"""A hypothesis fitted to the equations, and what all fits to the same data share."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from flexdyn.diagnose.equations.covariance import SampleNoise, Whitener
from flexdyn.diagnose.equations.equations import Equations
from flexdyn.diagnose.hypothesis.hypothesis import Hypothesis
from flexdyn.diagnose.hypothesis.regression import Regression
from flexdyn.diagnose.lazy import lazy
from flexdyn.effects import Effect
from flexdyn.model.uncertain_parameters import FileNumber

Array = NDArray[np.float64]
CORRELATION_BLOCK = 0.5
"""Length of the blocks over which rows are taken to be correlated [s]."""


@dataclass(frozen=True, eq=False)
class Fit:
    """A fitted hypothesis.

    Attributes:
        hypothesis: with its numbers at their best.
        equations: of its model.
        regression: at the last step; its columns are the file's numbers, then the effects' unknowns.
        space: it was made in.
        scales: of the effects' unknowns.
        held: columns of those that stand at a bound and would leave it.
        free: the problem in which they are not held, which tells how well they are known; None: there are none.
        taken: where the slopes of the file's numbers were taken; None: here.
        block: rows that are correlated; 0: those of half a second of the equations.
        stationary: whether shares of the last step were tried, and none of them was worth it.
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
        """Sum of squares of white rows and priors that the last step promises."""
        return self.regression.chi2

    @property
    def reached(self) -> float:
        """The same where the hypothesis stands: the two differ where the fit has not come to an end."""
        return self.regression.at_zero

    @property
    def reduced(self) -> float:
        """Mean square of the white rows: 1 where only noise is left."""
        return self.regression.data_chi2 / self.regression.rows

    @property
    def step(self) -> Array:
        """To where the last linear problem is least, the offsets of the encoders included (columns,)."""
        step = self.regression.values.copy()
        step[list(self.held)] = 0.0
        return step

    def std(self) -> dict[tuple[Effect, str], float]:
        """Standard deviations of the effects' unknowns."""
        first = len(self.hypothesis.factors)
        sigma = self._spread[first : first + len(self.scales)]
        keys = self.hypothesis.unknowns()
        return {key: float(s) * scale for key, s, scale in zip(keys, sigma, self.scales, strict=True)}

    def factor_std(self) -> dict[FileNumber, float]:
        """Standard deviations of the file's numbers' factors."""
        return {number: float(s) for number, s in zip(self.hypothesis.factors, self._spread, strict=False)}

    @lazy
    def _spread(self) -> Array:
        """Of all columns: what white rows give, or the sandwich over blocks of half a second where that is more.

        Where more than noise is left, its filters bend the numbers as well: by as much again as the rows are off.
        """
        spread = self._spread_of(self.regression)
        if self.free is not None:
            spread[list(self.held)] = self._spread_of(self.free)[list(self.held)]
        return spread

    def _spread_of(self, regression: Regression) -> Array:
        filters, kinds = self.equations.filters, self.equations.kinds
        block = self.block or max(1, round(CORRELATION_BLOCK / (filters.every * self.equations.data[0].dt))) * len(
            kinds
        )
        both = (regression.covariance, regression.sandwich(block))
        return np.asarray(np.sqrt(max(1.0, self.reduced) * np.maximum(*(np.diag(each) for each in both))))


@dataclass(frozen=True, eq=False)
class Workspace:
    """What all fits to the same data share.

    Attributes:
        equations: of the model as it was given.
        whiten: of their rows.
        noise: of the channels, from which the weights are.
        numbers: whitened derivatives of the file's numbers (rows, numbers).
        nuisance: whitened columns of offsets of the encoders, which must be allowed for and are not reported (rows, k).
        nuisance_sigma: how large those are (k,).
        channels: whose offsets they are.
        beliefs: prior of an effect's parameter: how far its centre is from the value, and its standard deviation.
    """

    equations: Equations
    whiten: Whitener
    noise: SampleNoise
    numbers: Array
    nuisance: Array
    nuisance_sigma: Array
    channels: tuple[str, ...] = ()
    beliefs: Callable[[Effect, str], tuple[float, float]] | None = None

    def white(self, residual: Array) -> Array:
        """A residual made white, the encoders' offsets that suit it best taken off (rows,)."""
        white, offsets = self.whiten(residual), self.nuisance
        loose = np.diag(1.0 / self.nuisance_sigma**2)
        return np.asarray(white - offsets @ np.linalg.solve(offsets.T @ offsets + loose, offsets.T @ white))

    @property
    def rows(self) -> int:
        """Rows that say something."""
        return int((~self.whiten.mask).sum())
