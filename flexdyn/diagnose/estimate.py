"""A model with numbers moved and effects added, fitted to the equations by Gauss-Newton."""

from __future__ import annotations

import dataclasses
import math
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from flexdyn.diagnose import columns
from flexdyn.diagnose.covariance import Noise, Whitener
from flexdyn.diagnose.equations import Equations
from flexdyn.diagnose.hypothesis import ROUNDING, Hypothesis, bounded, moved
from flexdyn.diagnose.numbers import FileNumber
from flexdyn.diagnose.regression import Regression
from flexdyn.effects import Effect, KinematicError, Payload, SensorEffect, SensorOffset
from flexdyn.errors import SimulationError

Array = NDArray[np.float64]
SETTLED = 0.05
"""Drop of chi^2, in units of what is left of a row, below which another step is not worth its time."""
BLOCK = 0.5
"""Length of the blocks over which rows are taken to be correlated [s]."""
AHEAD = 2
"""Steps that may go on from where chi^2 rose: numbers that multiply one another lie along a bent valley, whose floor a
straight step leaves and the next one finds again (the watchdog of Chamberlain et al., 1982)."""
A_FEW = 4
"""Steps after which a fit that does not come near what it is wanted for is given up."""
SHORTER = 0.3
"""Share of a step that is tried where all of it was too much."""
FAR = 0.05
"""Relative distance of a number from its given value beyond which its derivative is another one."""
LOOSE = 1e3
"""Relative width of the prior of a number that is out of its tolerance."""
ROUGH = 2.0
"""Mean square of the equations' white residuals above which the filters, and not the noise, limit the fit."""
ALIKE = 0.1
"""Autocorrelation of what is left below which rows are taken to be independent of one another."""


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
    """

    hypothesis: Hypothesis
    equations: Equations
    regression: Regression
    space: Workspace
    scales: tuple[float, ...] = field(default=())
    held: tuple[int, ...] = ()
    free: Regression | None = None

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

    @cached_property
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
        block = max(1, round(BLOCK / (filters.every * self.equations.data[0].dt))) * len(kinds)
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
        temper: factor on the priors of the file's numbers, where more than noise is left.
    """

    equations: Equations
    whiten: Whitener
    noise: Noise
    numbers: Array
    nuisance: Array
    nuisance_sigma: Array
    channels: tuple[str, ...] = ()
    temper: float = 1.0

    @property
    def rows(self) -> int:
        """Rows that say something."""
        return int((~self.whiten.mask).sum())


def fit(start: Hypothesis, space: Workspace, steps: int = 12, hopeless: float = math.inf) -> Fit:
    """Gauss-Newton from a hypothesis: every number of the file within its prior, every unknown of its effects.

    Args:
        start: where to begin.
        space: data, weights and the derivatives that do not change.
        steps: at most so many.
        hopeless: chi^2 beyond which it is given up after a few steps, if the next one does not promise less either.

    Raises:
        SimulationError: where it begins, the equations are not finite.
    """
    best = base = linearised(start, space)
    share, ahead = 1.0, 0
    for k in range(steps - 1):
        if best.reached - best.chi2 < SETTLED * max(1.0, best.reduced) or (k >= A_FEW and best.chi2 > hopeless):
            break
        try:
            made = linearised(moved(base.hypothesis, share * base.step, base.scales), space)
        except SimulationError:  # too far
            base, share = best, SHORTER * share
            continue
        if made.reached <= best.reached:
            best, base, share, ahead = made, made, min(1.0, share / SHORTER), 0
            continue
        if share == 1.0 and ahead < AHEAD and made.chi2 < best.reached:
            base, ahead = made, ahead + 1
        else:
            base, share = best, SHORTER * share
    return _counted(best, space)


def _counted(made: Fit, space: Workspace) -> Fit:
    """The fit with the offsets of its encoders in its hypothesis."""
    values = made.regression.values[made.regression.X.shape[1] - len(space.channels) :]
    counts = tuple(SensorOffset(name, offset=float(x)) for name, x in zip(space.channels, values, strict=True))
    return dataclasses.replace(made, hypothesis=dataclasses.replace(made.hypothesis, counts=counts))


def linearised(hypothesis: Hypothesis, space: Workspace) -> Fit:
    """The least-squares problem at a hypothesis; its step is not taken.

    Raises:
        SimulationError: the equations are not finite there.
    """
    at = space.equations.of(hypothesis.model())
    unknowns = hypothesis.unknowns()
    scales = tuple(_scale(effect, name) for effect, name in unknowns)
    with np.errstate(over="ignore", invalid="ignore"):
        y, X = _rows(hypothesis, at, space, scales)
        finite = np.isfinite(y @ y) and np.isfinite(np.einsum("ij,ij->j", X, X)).all()
    if not finite:
        raise SimulationError("the equations are not finite along the measured motion", reason="overflow")
    centre, sigma = _priors(hypothesis, len(unknowns), space.temper)
    regression = Regression(
        y=y,
        X=X,
        centre=np.concatenate([centre, np.zeros(space.nuisance.shape[1])]),
        sigma=np.concatenate([sigma, space.nuisance_sigma]),
        rows=space.rows,
        nuisances=space.nuisance.shape[1],
    )
    held = _held(hypothesis, regression, scales)
    if not held:
        return Fit(hypothesis, at, regression, space, scales)
    X, sigma = regression.X.copy(), regression.sigma.copy()
    X[:, held], sigma[list(held)] = 0.0, 1e-9  # the others must do without them
    return Fit(hypothesis, at, dataclasses.replace(regression, X=X, sigma=sigma), space, scales, held, regression)


def _rows(hypothesis: Hypothesis, at: Equations, space: Workspace, scales: tuple[float, ...]) -> tuple[Array, Array]:
    """White residuals (rows,) and their slopes by the numbers, the unknowns and the encoders' offsets (rows, k)."""
    slopes = [_slopes_of_numbers(hypothesis, at, space)]
    raw = [
        s * columns.of_parameter(at, effect, name, 0.1 * s)
        for (effect, name), s in zip(hypothesis.unknowns(), scales, strict=True)
    ]
    if raw:
        slopes.append(space.whiten(np.stack(raw, axis=1)))
    return space.whiten(at.residual), np.hstack([*slopes, space.nuisance])


def _held(hypothesis: Hypothesis, regression: Regression, scales: tuple[float, ...]) -> tuple[int, ...]:
    """Columns of those unknowns that stand at a bound and would leave it."""
    first = len(hypothesis.factors)
    wanted = regression.values[first : first + len(scales)] * np.array(scales)
    held = []
    for k, ((effect, name), dx) in enumerate(zip(hypothesis.unknowns(), wanted.tolist(), strict=True)):
        value = getattr(effect, name)
        if abs(bounded(effect, name, dx) - value) < ROUNDING * abs(dx):
            held.append(first + k)
    return tuple(held)


def tempering(made: Fit) -> float:
    """Factor on the priors with which they weigh against what is left, not against a noise that is not reached.

    The mean square of what is left, times rows for each independent one by their mean autocorrelation.
    """
    if made.reduced <= ROUGH:
        return 1.0
    rows = made.regression.left[: len(made.regression.y)].reshape(-1, len(made.equations.kinds))
    power, total = float((rows**2).sum()), 1.0
    for lag in range(1, len(rows) // 4):
        alike = float((rows[lag:] * rows[:-lag]).sum()) / power
        if alike < ALIKE:
            break
        total += 2.0 * alike
    return total * made.reduced


def _slopes_of_numbers(hypothesis: Hypothesis, at: Equations, space: Workspace) -> Array:
    """Whitened derivatives of the file's numbers (rows, numbers), anew for those that have become other ones.

    These are numbers that are far from what was given, and those of a joint whose encoders or spring were wrong: it
    winds by less than a sensor may be off. A link's mass, its place and its inertia multiply one another: where one of
    them is far off or the links carry more, all are taken anew.
    """
    numbers, effects = hypothesis.factors, hypothesis.effects
    far = {n for n, factor in numbers.items() if n in hypothesis.freed and abs(factor - 1.0) > FAR}
    links = any(number.joint is None for number in far) or any(isinstance(e, Payload) for e in effects)
    joints = {getattr(e, "joint", None) for e in effects if isinstance(e, SensorEffect | KinematicError)}
    slopes = space.numbers.copy() if far or joints or links else space.numbers
    for k, (number, factor) in enumerate(numbers.items()):
        if number in far or number.joint in joints or (links and number.joint is None):
            slopes[:, k] = space.whiten(columns.of_number(at, number)) / factor
    return slopes


def _scale(effect: Effect, name: str) -> float:
    """A size of a parameter by which steps and columns are measured."""
    value = abs(getattr(effect, name))
    if name in ("phase",):
        return 1e-2
    if name in ("rest", "lower", "upper"):
        return 1e-3
    return 0.01 * value if value > 0.0 else {"damping": 1e-3, "offset": 1e-4}.get(name, 1e-4)


def _priors(hypothesis: Hypothesis, unknowns: int, temper: float) -> tuple[Array, Array]:
    centre = [1.0 - factor for factor in hypothesis.factors.values()] + [0.0] * unknowns
    widths = [LOOSE if n in hypothesis.freed else max(n.tolerance, 1e-9) for n in hypothesis.factors]
    return np.array(centre), np.array([width / math.sqrt(temper) for width in widths] + [math.inf] * unknowns)
