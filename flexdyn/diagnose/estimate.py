"""A model with numbers moved and effects added, fitted to the equations by Gauss-Newton."""

from __future__ import annotations

import dataclasses
import math
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from flexdyn.diagnose import columns
from flexdyn.diagnose.abreast import abreast
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
NEAR = 5.0
"""Steps of an unknown's own scale, a hundredth of its value, over which slopes of the file's numbers are the same."""
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
        taken: where the slopes of the file's numbers were taken; None: here.
    """

    hypothesis: Hypothesis
    equations: Equations
    regression: Regression
    space: Workspace
    scales: tuple[float, ...] = field(default=())
    held: tuple[int, ...] = ()
    free: Regression | None = None
    taken: Hypothesis | None = None

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
        watched = share == 1.0 and ahead < AHEAD
        made = _after(base, share, math.inf if watched else best.reached)
        if made is None:
            base, share = best, SHORTER * share
            continue
        if made.reached <= best.reached:
            ahead = 0 if share == 1.0 else ahead  # where it did not help it is not tried again
            best, base, share = made, made, min(1.0, share / SHORTER)
        elif watched and made.chi2 < best.reached:
            base, ahead = made, ahead + 1
        else:
            base, share = best, SHORTER * share
    return _counted(best, space)


def _after(base: Fit, share: float, most: float) -> Fit | None:
    """The problem after a share of a step; None where more is left than may be, for which no slopes are taken."""
    trial = moved(base.hypothesis, share * base.step, base.scales)
    try:
        at = base.space.equations.of(trial.model())
        if most < math.inf and _reached(trial, at, base.space) > most:
            return None
        return linearised(trial, base.space, base, at)
    except SimulationError:  # too far
        return None


def _counted(made: Fit, space: Workspace) -> Fit:
    """The fit with the offsets of its encoders in its hypothesis."""
    values = made.regression.values[made.regression.X.shape[1] - len(space.channels) :]
    counts = tuple(SensorOffset(name, offset=float(x)) for name, x in zip(space.channels, values, strict=True))
    return dataclasses.replace(made, hypothesis=dataclasses.replace(made.hypothesis, counts=counts))


def _reached(hypothesis: Hypothesis, at: Equations, space: Workspace) -> float:
    """`Fit.reached` without any slopes; infinite where the equations are not finite."""
    with np.errstate(over="ignore", invalid="ignore"):
        y = space.whiten(at.residual)
        if not np.isfinite(y @ y):
            return math.inf
    centre, sigma = _priors(hypothesis, 0, space.temper)
    nuisances = space.nuisance.shape[1]
    alone = Regression(y, space.nuisance, np.zeros(nuisances), space.nuisance_sigma, space.rows, nuisances)
    return alone.at_zero + float(((centre / sigma) ** 2).sum())


def linearised(hypothesis: Hypothesis, space: Workspace, before: Fit | None = None, at: Equations | None = None) -> Fit:
    """The least-squares problem at a hypothesis; its step is not taken.

    Args:
        hypothesis: of the model.
        space: data, weights and the derivatives that do not change.
        before: the same effects with other numbers; where these are near, its slopes of the file's numbers do.
        at: the equations there; None: they are made.

    Raises:
        SimulationError: the equations are not finite there.
    """
    at = at or space.equations.of(hypothesis.model())
    unknowns = hypothesis.unknowns()
    scales = tuple(_scale(effect, name) for effect, name in unknowns)
    taken = None if before is None else before.taken or before.hypothesis
    if taken is not None and not _near(hypothesis, taken):
        taken = None
    known = before.regression.X[:, : len(hypothesis.factors)] if before is not None and taken is not None else None
    with np.errstate(over="ignore", invalid="ignore"):
        y, X = _rows(hypothesis, at, space, scales, known)
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
        return Fit(hypothesis, at, regression, space, scales, taken=taken)
    X, sigma = regression.X.copy(), regression.sigma.copy()
    X[:, held], sigma[list(held)] = 0.0, 1e-9  # the others must do without them
    bound = dataclasses.replace(regression, X=X, sigma=sigma)
    return Fit(hypothesis, at, bound, space, scales, held, regression, taken)


def _near(one: Hypothesis, other: Hypothesis) -> bool:
    """Whether the numbers of the same effects, and of the file, are so near that the slopes are the same."""
    pairs = zip(one.unknowns(), other.unknowns(), strict=True)
    moved = (abs(getattr(a, name) - getattr(b, name)) / _scale(b, name) for (a, name), (b, _) in pairs)
    factors = zip(one.factors.values(), other.factors.values(), strict=True)
    return all(x <= NEAR for x in moved) and all(abs(a / b - 1.0) <= FAR for a, b in factors)


def _rows(
    hypothesis: Hypothesis, at: Equations, space: Workspace, scales: tuple[float, ...], known: Array | None
) -> tuple[Array, Array]:
    """White residuals (rows,) and their slopes by the numbers, the unknowns and the encoders' offsets (rows, k).

    Those by the numbers may be known.
    """
    y = space.whiten(at.residual)

    def slope(unknown: tuple[tuple[Effect, str], float]) -> Array:
        (effect, name), scale = unknown
        return space.whiten(scale * columns.of_parameter(at, effect, name, 0.1 * scale))

    own = abreast(slope, zip(hypothesis.unknowns(), scales, strict=True))
    numbers = _slopes_of_numbers(hypothesis, at, space) if known is None else known
    return y, np.column_stack([numbers, *own, space.nuisance])


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
    anew = [n for n in numbers if n in far or n.joint in joints or (links and n.joint is None)]
    slopes = space.numbers.copy() if anew else space.numbers
    places = [k for k, number in enumerate(numbers) if number in anew]
    for k, slope in zip(
        places, abreast(lambda n: space.whiten(columns.of_number(at, n)) / numbers[n], anew), strict=True
    ):
        slopes[:, k] = slope
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
