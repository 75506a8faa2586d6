"""Data that takes no part in a fit: what it says of a model, and whether it wants an effect."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from flexdyn.diagnose.fitted import BLOCK, Fit, Workspace
from flexdyn.diagnose.gap import Shot, shoot
from flexdyn.diagnose.hypothesis import Hypothesis, kind_and_place
from flexdyn.diagnose.lazy import lazy
from flexdyn.diagnose.windows import Windows
from flexdyn.effects import Effect, EncoderEccentricity, KinematicError, SensorOffset

Array = NDArray[np.float64]
SURE = 3.0
"""Standard errors by which data that took no part must be less off with an effect than without it."""
FAIR = 2.0
"""The same for an effect that is beyond doubt in the data that it was fitted to: there the check must only agree."""
EXPLAINED = 1.3
"""A median window that is off by no more than so many times the floor is explained."""
BULK = 0.5
"""Share of what is left over noise that an effect must take where windows alone do not decide."""
SOLID = 100.0
"""Drop of the squared white rows from which the equations alone may speak for an effect."""
NOISE = 1.1
"""A gap up to here may be noise alone: windows are few."""
HARDLY_MORE = 1.1
"""Factor by which the check's gap may grow where windows and equations both surely say that it is less off: a few
windows, of what is still missing, make most of it."""
COLLAPSED = 0.2
"""Share of the check's gap that is left where an effect takes it though few windows show it, such as an end stop's."""
NEAR_NOISE = 0.05
"""Share of noise by which the equations of a right model may be off: filters, and noise that is estimated."""
COUNT = math.sqrt(12.0)
"""Of an encoder, in standard deviations of its noise."""
SLIGHT_ROWS, SLIGHT_LOG = 3.0, 0.002
"""Standard errors at least: of a drop of all squared white rows, and of the mean logarithm of what windows are off.

Laws that do the same to the data differ by rounding alone, which always speaks for the same one.
"""


@dataclass(frozen=True, eq=False)
class Trial:
    """A model over data that took no part in its fit.

    Attributes:
        shot: its simulated windows.
        rows: squared white rows of its equations by blocks of half a second (blocks,).
        count: of rows that say something in each (blocks,).
        exact: whether no position had to be made up: else the equations are bent by what nobody saw.
    """

    shot: Shot
    rows: Array
    count: Array
    exact: bool = True

    @property
    def gap(self) -> float:
        """Of all windows [1]."""
        return self.shot.gap

    @property
    def median(self) -> float:
        """Gap of the median window [1]."""
        return float(np.median(self.shot.by_window))

    @lazy
    def floor(self) -> float:
        """Gap of a perfect model, by a simulation of its own [1]."""
        return self.shot.floor()

    @property
    def excess(self) -> float:
        """What the equations leave over noise, by all rows."""
        return max(float(self.rows.sum() - self.count.sum()), 0.0)

    @property
    def at_noise(self) -> bool:
        """Whether the equations leave no more than noise."""
        rows, count = float(self.rows.sum()), float(self.count.sum())
        return rows < (1.0 + NEAR_NOISE) * count + 2.0 * math.sqrt(2.0 * count)


@dataclass(frozen=True, eq=False)
class Check:
    """Recordings that take no part in the fit, cut into windows, and their equations.

    Attributes:
        windows: with their own noise.
        space: their equations and weights.
    """

    windows: Windows
    space: Workspace

    def of(self, hypothesis: Hypothesis, near: Shot | None = None) -> Trial:
        """Try a hypothesis on them; near: a shot of another one, from whose first states the search begins."""
        white = self._white(hypothesis)
        equations, mask = self.space.equations, self.space.whiten.mask
        block = max(1, round(BLOCK / (equations.filters.every * equations.data[0].dt))) * len(equations.kinds)
        begins = np.arange(0, len(white), block)
        rows, count = (np.add.reduceat(each, begins) for each in (white**2, (~mask).astype(float)))
        exact = not equations.made_up.any()
        return Trial(shoot(hypothesis.seen(), self.windows, near), rows[count > 0], count[count > 0], exact)

    def _white(self, hypothesis: Hypothesis) -> Array:
        """White rows (rows,), the encoders' counts taken off."""
        space = self.space
        white = space.whiten(space.equations.of(hypothesis.model()).residual)
        offsets = {effect.channel: effect.offset for effect in hypothesis.counts}
        return np.asarray(white + space.nuisance @ np.array([offsets.get(name, 0.0) for name in space.channels]))


def confirmed(now: Trial, before: Fit, trial: Trial, after: Fit) -> bool:
    """Whether data that took no part wants an effect.

    Its windows must surely be less off, and no more off in all unless that is noise or equations agree. Where they say
    little, because noise decides in them what sticks, the equations may speak instead, for an effect that takes the
    bulk of what was left; if it leaves them nothing but noise, windows need only not object. Data that is at noise with
    and without it says too little: there it must not object to what is beyond doubt in the fit. Where a position was
    made up and windows are at noise, an effect must be beyond doubt in the fit as well. One that only puts back numbers
    of the file which had been bent to do its work must do no harm. Errors of position that no encoder counts, which
    filters and rounding make, are wanted by windows alone. What is beyond doubt in the fit and takes nearly all of the
    check's gap is wanted however few windows show it.
    """
    windows = better(now, trial)
    rows = surely_less(now.rows, trial.rows)
    slight = any(_below_a_count(effect, after) for effect in _added(before, after))
    if unbends(before, after):
        return min(windows, rows) > -SURE and not slight
    doubtless = before.chi2 - after.chi2 > SOLID
    if not trial.exact and now.median <= 1.0 and not doubtless:  # equations are bent by more than this is worth
        return False
    solid = trial.exact and doubtless
    if solid and now.at_noise and trial.at_noise and min(windows, rows) > -1.0:
        return not slight
    if slight:
        return windows > SURE and trial.gap < max(now.gap, NOISE)
    if windows > (FAIR if solid else SURE) and trial.gap <= max(now.gap, NOISE):
        return True
    if solid and min(windows, rows) > SURE and trial.gap <= HARDLY_MORE * now.gap:
        return True
    if doubtless and windows > 0.0 and trial.gap < COLLAPSED * now.gap:
        return True
    bulk = float(now.rows.sum() - trial.rows.sum()) > BULK * now.excess
    return solid and bulk and windows > (-1.0 if trial.at_noise else 0.0) and rows > SURE


def _added(before: Fit, after: Fit) -> list[Effect]:
    """Effects of a fit that another one does not have."""
    known = {kind_and_place(effect) for effect in before.hypothesis.effects}
    return [effect for effect in after.hypothesis.effects if kind_and_place(effect) not in known]


def _below_a_count(effect: Effect, made: Fit) -> bool:
    """Whether an effect is an error of position smaller than one count of its joint's coarser encoder."""
    if not isinstance(effect, EncoderEccentricity | KinematicError | SensorOffset):
        return False
    if not isinstance(effect, KinematicError) and effect.signal not in ("q", "theta"):
        return False
    size = effect.offset if isinstance(effect, SensorOffset) else effect.amplitude
    j, noise = made.equations.true.index(effect.joint), made.space.noise
    return abs(size) < COUNT * float(np.nanmax([noise.q[j], noise.theta[j]]))


def unbends(before: Fit, after: Fit) -> bool:
    """Whether the file's numbers had been bent to do an effect's work."""
    gained = before.chi2 - after.chi2
    return before.regression.prior_chi2 - after.regression.prior_chi2 > 0.5 * gained


def better(before: Trial, after: Trial) -> float:
    """By how many standard errors a model's windows are less off than another's, by gap or by white surprises.

    The gap sees what adds up over a window, the surprises what is wrong at an instant; an effect may show in one of
    them alone.
    """
    one, two = before.shot, after.shot
    gaps = _logs(one.by_window) - _logs(two.by_window)
    surprises = _logs(one.misfit) - _logs(two.misfit)
    return max(_significance(gaps, SLIGHT_LOG), _significance(surprises, SLIGHT_LOG))


def surely_less(before: Array, after: Array) -> float:
    """By how many standard errors sums of squared white rows (blocks,) are less with one model than with another."""
    return _significance(before - after, SLIGHT_ROWS / max(len(before), 1))


def _logs(size: Array) -> Array:
    """Logarithms; a window that counts nothing is as far off with one model as with the other."""
    return np.asarray(np.log(np.maximum(size, 1e-12)))


def _significance(drop: Array, least: float) -> float:
    """Mean over standard error, outermost tenths drawn in: a window on the wrong side of a stick decides nothing."""
    drop = drop[np.isfinite(drop)]
    if len(drop) < 2:
        return 0.0
    drop = np.clip(drop, *np.quantile(drop, [0.1, 0.9]))
    return float(drop.mean() / max(float(drop.std(ddof=1)) / np.sqrt(len(drop)), least))
