"""A hypothesis fitted to simulated windows by Gauss-Newton; windows include reversals, which the equations mask."""

from __future__ import annotations

import dataclasses
import math
from dataclasses import dataclass

import numpy as np

from flexdyn.arrays import Array
from flexdyn.diagnose.constants import CERTAIN_SIGMAS, ERRORS_PER_WINDOW, NOISE_LEVEL_ERROR, WORTHWHILE_GAIN
from flexdyn.diagnose.hypothesis.fitted import Fit
from flexdyn.diagnose.hypothesis.hypothesis import Hypothesis, moved
from flexdyn.diagnose.hypothesis.linear import priors, scales_of, within_bounds
from flexdyn.diagnose.hypothesis.regression import Regression
from flexdyn.diagnose.shooting.gap import Shot, shoot
from flexdyn.diagnose.shooting.windows import Windows
from flexdyn.effects import Effect
from flexdyn.errors import FlexdynError
from flexdyn.model.uncertain_parameters import FileNumber

SCALED_STEP = 0.1
"""Step of the differences, in scales of the fit; a factor's in the part of its tolerance that this is."""
WINDOW_FIT_STEPS = 8
"""Gauss-Newton steps at most."""
STEP_SHARES = (1.0, 0.3, 0.1)
"""Shares of a step that are tried."""
SEARCH_FACTORS = (1.5, 1.2, 1.06, 1.02, 1.007)
"""Factors of the search for numbers of laws that have no linear one [1]."""
WORTHWHILE_SHARE = 0.05
"""The same as a share of what separates the windows from noise [1]: steps that gain less do not lead there."""


def slopes(here: Hypothesis, shot: Shot, scales: tuple[float, ...]) -> Array:
    """Differences of the whitened windows by every number, from the same first states (rows, numbers).

    Args:
        here: the hypothesis that was simulated.
        shot: its windows.
        scales: of the effects' unknowns.
    """
    white = shot.whitened().ravel()
    columns = []
    for k in range(len(here.factors) + len(scales)):
        stepped, step = _with_a_step(here, k, scales)
        columns.append((shot.whitened(stepped.seen()).ravel() - white) / step)
    return np.stack(columns, axis=1)


def _with_a_step(here: Hypothesis, k: int, scales: tuple[float, ...]) -> tuple[Hypothesis, float]:
    """The hypothesis with one number moved, and by how much."""
    numbers = len(here.factors)
    if k < numbers:
        number, factor = list(here.factors.items())[k]
        step = SCALED_STEP * max(number.tolerance, 1e-3)
        return dataclasses.replace(here, factors={**here.factors, number: factor + step}), step
    effect, name = here.unknowns()[k - numbers]
    changed = effect.replace(**{name: getattr(effect, name) + SCALED_STEP * scales[k - numbers]})
    return here.with_instead(effect, changed), SCALED_STEP


def unlike_noise(shot: Shot, floor: float = 1.0) -> bool:
    """Whether windows leave together more than noise, chance and a misjudged level of the noise.

    Args:
        shot: the windows; where only some are off, their median says nothing of it.
        floor: the gap of a perfect model, if it is more than 1.
    """
    chance = CERTAIN_SIGMAS * math.sqrt(2.0 / (ERRORS_PER_WINDOW * len(shot.x0)))
    return shot.left > (1.0 + NOISE_LEVEL_ERROR + chance) * max(floor, 1.0) ** 2


@dataclass(frozen=True, eq=False)
class WindowFit:
    """A hypothesis and its windows.

    Attributes:
        made: its numbers; the regression is that of the windows, each weighted by its own error.
        shot: the windows.
        log_posterior: of its numbers: their likelihood over the windows and their priors.
    """

    made: Fit
    shot: Shot
    log_posterior: float

    @property
    def weight(self) -> Array:
        """One over the size of the error of its window, at least that of noise, of every innovation (rows,)."""
        count = self.shot.whitened().shape[1]
        weight = np.where(self.shot.failed, 0.0, 1.0 / np.sqrt(np.maximum(self.shot.misfit, 1.0)))
        return np.repeat(weight, count)

    @property
    def worthwhile(self) -> float:
        """Log posterior that a step to here must have gained for another one [1]."""
        return max(WORTHWHILE_GAIN, WORTHWHILE_SHARE * self.shot.above_noise)

    @property
    def explains(self) -> bool:
        """Whether the windows are at noise, and no number of the file is out of its tolerance for it."""
        return not unlike_noise(self.shot) and not self.made.hypothesis.displaced

    @classmethod
    def of(cls, start: Fit, windows: Windows, near: Array | None = None) -> WindowFit:
        """The windows of a fitted hypothesis; near: first states that suited a similar one (windows, nx)."""
        shot = shoot(start.hypothesis.seen(), windows, near)
        centre, sigma = priors(start.hypothesis, start.space)
        return cls(start, shot, shot.log_likelihood - 0.5 * float(((centre / sigma) ** 2).sum()))

    def with_one_more(self, effect: Effect | None, number: FileNumber | None, step: Array) -> WindowFit:
        """The windows with one effect more, or with a number that its tolerance does not hold.

        Args:
            effect: that is added; None: nothing.
            number: that is free; None: nothing.
            step: of all numbers that are there (columns,).
        """
        here, space = moved(self.made.hypothesis, step, self.made.scales), self.made.space
        effects = here.effects if effect is None else (*here.effects, effect)
        freed = here.freed if number is None else here.freed | {number}
        here = dataclasses.replace(here, effects=effects, freed=freed)
        made = dataclasses.replace(self.made, hypothesis=here, equations=space.equations.of(here.model()))
        return WindowFit.of(made, self.shot.windows, self.shot.x0)


def fit_to_windows(start: WindowFit) -> WindowFit:
    """Fit by Gauss-Newton; the result is never worse than the start.

    ``max  sum_w log p(window w | numbers) + log p(numbers)``: the windows' first states are eliminated by a Kalman
    filter, and each window weighs by the error that it leaves beyond noise (iteratively reweighted least squares).
    Steps that are small against what is left beyond noise do not lead to noise: the fit ends, and is not stationary.
    """
    best, J = start, slopes(start.made.hypothesis, start.shot, scales_of(start.made.hypothesis))
    for _ in range(WINDOW_FIT_STEPS):
        problem = _problem(best, J)
        after = _better_step(best, problem)
        if after is None:
            return dataclasses.replace(best, made=dataclasses.replace(problem, stationary=True))
        gained, best = after.log_posterior - best.log_posterior, after
        if gained < best.worthwhile:
            settled = gained < WORTHWHILE_GAIN
            return dataclasses.replace(best, made=dataclasses.replace(_problem(best, J), stationary=settled))
        J = slopes(best.made.hypothesis, best.shot, scales_of(best.made.hypothesis))
    return dataclasses.replace(best, made=_problem(best, J))


def to_windows(windows: Windows, made: Fit, here: Hypothesis) -> Fit:
    """Another hypothesis, fitted to windows instead of the equations, which may not see what windows have found.

    Args:
        windows: of the data.
        made: a fit of these data.
        here: the hypothesis.
    """
    start = dataclasses.replace(made, hypothesis=here, equations=made.space.equations.of(here.model()))
    return fit_to_windows(WindowFit.of(start, windows)).made


def searched(start: WindowFit) -> WindowFit:
    """The same with those numbers of laws without a linear one that suit the windows best, found without slopes.

    How a link strikes the ends of a gap is far from linear in its width: a fit that begins at another width stalls.
    Each number is made larger or smaller by a factor, and by a smaller one where that is no better (a pattern search:
    Hooke and Jeeves, J. ACM 8, 1961).
    """
    best = start
    for place, effect in enumerate(start.made.hypothesis.effects):
        for name in () if effect.linear or effect.linear_bounds else effect.axes:
            for factor in SEARCH_FACTORS:
                best = _scaled_while_better(best, place, name, factor)
    return best


def _scaled_while_better(best: WindowFit, place: int, name: str, factor: float) -> WindowFit:
    """The windows with a number of an effect larger or smaller by a factor, as often as that is worth a step."""
    for step in (factor, 1.0 / factor):
        first = best
        while (other := _with_scaled(best, place, name, step)).log_posterior > best.log_posterior + WORTHWHILE_GAIN:
            best = other
        if best is not first:
            break
    return best


def _with_scaled(here: WindowFit, place: int, name: str, factor: float) -> WindowFit:
    """The windows with another number of an effect; as they are where the law does not allow it."""
    hypothesis = here.made.hypothesis
    effect = hypothesis.effects[place]
    try:
        changed = hypothesis.with_instead(effect, effect.replace(**{name: factor * getattr(effect, name)}))
        at = here.made.space.equations.of(changed.model())
        made = dataclasses.replace(here.made, hypothesis=changed, equations=at)
        return WindowFit.of(made, here.shot.windows, here.shot.x0)
    except FlexdynError:
        return here


def _problem(here: WindowFit, J: Array) -> Fit:
    """The linear problem that the windows are near a hypothesis."""
    hypothesis, space = here.made.hypothesis, here.made.space
    white = here.shot.whitened()
    finite = np.asarray(np.isfinite(J).all(axis=1))  # a response that diverges says nothing
    weight, J = np.where(finite, here.weight, 0.0), np.where(finite[:, None], J, 0.0)
    centre, sigma = priors(hypothesis, space)
    rows = max(int((weight > 0.0).sum()), 1)
    regression = Regression(weight * white.ravel(), weight[:, None] * J, centre, sigma, rows)
    at = here.made.equations
    return within_bounds(Fit(hypothesis, at, regression, space, scales_of(hypothesis), block=white.shape[1]))


def _better_step(here: WindowFit, problem: Fit) -> WindowFit | None:
    """After the first share of the step that is better; None: there is none."""
    for share in STEP_SHARES:
        hypothesis = moved(problem.hypothesis, share * problem.step, problem.scales)
        at = problem.space.equations.of(hypothesis.model())
        made = dataclasses.replace(problem, hypothesis=hypothesis, equations=at)
        trial = WindowFit.of(made, here.shot.windows, here.shot.x0)
        if trial.log_posterior > here.log_posterior:
            return trial
    return None
