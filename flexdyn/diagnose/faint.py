"""Effects of which equations take hardly any notice, as a position is made up: simulated windows are asked for them.

What damps a transmission whose rotor nobody sees, say, is lost in the equations' filters; windows ring by it.
"""

from __future__ import annotations

import dataclasses
import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from flexdyn.diagnose.abreast import abreast
from flexdyn.diagnose.candidates import ENOUGH, Candidate
from flexdyn.diagnose.fitted import Fit
from flexdyn.diagnose.gap import Shot
from flexdyn.diagnose.linear import linearised
from flexdyn.diagnose.refine import Refined, refine
from flexdyn.diagnose.regression import Regression
from flexdyn.diagnose.screen import Screened, extended
from flexdyn.diagnose.search import Search
from flexdyn.diagnose.slopes import Slopes
from flexdyn.diagnose.stage import Alternative, Named, Stage
from flexdyn.diagnose.verify import NOISE, SURE, Trial, better, surely_less
from flexdyn.diagnose.windows import Windows
from flexdyn.effects import Effect, JointElasticity
from flexdyn.errors import InputError, SimulationError

Array = NDArray[np.float64]
WHAT = "asking simulated windows"
ROUNDS = 3
"""Gauss-Newton steps on windows with an effect more; without any, one says whether the file's numbers are all."""
BENT = 0.1
"""Share of its size by which a number has to move for its slopes to be taken anew."""
SOME, FEWEST = 1 / 3, 20
"""Share of the windows, those furthest off, on which effects are screened, and how many these are at least."""
KEPT, WORTH = 3, 0.3
"""Effects that are fitted to windows, and the share of the best one's promise from which they are."""
OF_NOISE = 0.8732, 1.105
"""Mean and standard deviation of the robust square of one surprise that is noise: 9 log(1 + x^2/9), x normal."""


def asked(search: Search, stage: Stage, windows: Windows) -> tuple[Stage, Refined | None]:
    """The stage with the one effect more that brings windows to noise, if the check wants it, and its numbers.

    Equations do not guide here, so less than all of what is left explained is no ground for a name. Where the file's
    numbers bring windows to noise by themselves, these numbers.

    Args:
        search: that came to an end.
        stage: its last one, in which nothing is named.
        windows: of the data of the fit.
    """
    temper, hypothesis = search.space.temper, stage.fitted.hypothesis
    seen = refine(hypothesis, windows, 0, temper=temper)
    if at_noise(seen):
        return stage, None
    search.say(WHAT, 0.0)
    worst = np.argsort(-seen.by_window)[: max(FEWEST, round(SOME * len(windows)))]
    bare = refine(hypothesis, dataclasses.replace(windows, places=windows.places[np.sort(worst)]), 1, temper=temper)
    if at_noise(bare):
        bare = refine(hypothesis, windows, 1, temper=temper, like=seen)
        trial = search.trial(bare.hypothesis)
        return (dataclasses.replace(stage, trial=trial), bare) if _wanted(stage.trial, trial) else (stage, None)
    if bare.slopes is None or bare.shot is None:
        return stage, None
    fitted = linearised(bare.hypothesis, search.space)
    worth = _promising(search, fitted, Seen.of(bare, bare.slopes, bare.shot))
    bare = refine(bare.hypothesis, windows, 0, temper=temper, like=seen)
    made = [each for each in abreast(lambda one: _fitted(fitted, one, bare, windows), worth) if each is not None]
    made.sort(key=lambda pair: pair[0].chi2 + pair[0].cost)
    if not made or not at_noise(made[0][1]) or made[0][0].drop < ENOUGH:
        return stage, None
    (best, numbers), others = made[0], [each for each, _ in made[1:]]
    trial = search.trial(numbers.hypothesis)
    if not all(_wanted(now, trial) for now in (stage.trial, search.trial(bare.hypothesis))):
        return stage, None
    rivals = tuple(each for each in others if each.behind(best) <= ENOUGH)
    among = tuple(Alternative(each.effect, None, each.behind(best), math.nan) for each, _ in made)
    return Stage(best.fitted, trial, (*stage.named, Named(best, rivals, among))), numbers


def _wanted(now: Trial, trial: Trial) -> bool:
    """Whether windows of the check are surely less off, and neither their gap nor the equations object."""
    harmless = trial.gap <= max(now.gap, NOISE) and surely_less(now.rows, trial.rows) > -SURE
    return harmless and better(now, trial) > SURE


def at_noise(refined: Refined) -> bool:
    """Whether the surprises of windows are surely no more than noise makes."""
    mean, std = OF_NOISE
    return refined.cost <= mean * refined.rows + SURE * std * math.sqrt(refined.rows)


@dataclass(frozen=True, eq=False)
class Seen:
    """What windows say near their best: the least-squares problem, with robust weights, and what it was made of."""

    shot: Shot
    slopes: Slopes
    regression: Regression

    @classmethod
    def of(cls, bare: Refined, slopes: Slopes, shot: Shot) -> Seen:
        """Of windows to which the numbers of a hypothesis were fitted."""
        root = np.sqrt(slopes.weight)
        centre = np.zeros(slopes.J.shape[1])
        centre[: len(bare.hypothesis.factors)] = 1.0 - np.array(list(bare.hypothesis.factors.values()))
        with np.errstate(divide="ignore"):
            sigma = 1.0 / np.sqrt(slopes.prior)
        y, X = shot.whitened().ravel() * root, slopes.J * root[:, None]
        return cls(shot, slopes, Regression(y, X, centre, sigma, bare.rows))

    def promise(self, choice: Screened) -> Screened:
        """The same choice by the drop of BIC that a linear step on windows promises."""
        proposal = choice.proposal
        try:
            X = np.stack([self._column(*unit) for unit in proposal.units(choice.point)], axis=1) if proposal else None
        except (InputError, SimulationError):
            X = None
        if proposal is None or X is None:
            return dataclasses.replace(choice, score=-math.inf)
        gain = self.regression.gain(np.where(np.isfinite(X), X, 0.0), proposal.positive, fixed=proposal.fixed)
        score = gain.chi2 - proposal.numbers * math.log(self.regression.rows)
        return dataclasses.replace(choice, score=score, values=gain.values)

    def _column(self, effect: Effect, scale: float) -> Array:
        """Change of the surprises (surprises,) with an effect more, over `scale`."""
        model = self.shot.model.replace(effects=[*self.shot.model.effects, effect])
        change = (self.shot.residual_of(model) - self.shot.residual) / scale
        return np.asarray(np.sqrt(self.slopes.weight) * self.shot.whitened_change(change).ravel())


def _promising(search: Search, fitted: Fit, seen: Seen) -> list[Screened]:
    """Effects by what a linear step on windows promises, best first, each at the grid point that equations prefer."""
    ranked = search.screen.ranked(fitted, 1.0)
    open_ = [each for each in ranked if each.proposal and each.proposal.place["effect"] != JointElasticity.name]
    found = sorted(abreast(seen.promise, open_, lambda share: search.say(WHAT, share)), key=lambda each: -each.score)
    return [each for each in found[:KEPT] if each.score >= max(ENOUGH, WORTH * found[0].score)]


def _fitted(before: Fit, choice: Screened, bare: Refined, windows: Windows) -> tuple[Candidate, Refined] | None:
    """A choice fitted to windows; None where it makes no sense."""
    start = extended(before, choice)
    if start is None or choice.proposal is None:
        return None
    try:
        refined = refine(start.tolerated(), windows, ROUNDS, temper=before.space.temper, anew=BENT, like=bare)
        made = linearised(refined.hypothesis, before.space)
    except (InputError, SimulationError):
        return None
    cost = choice.proposal.numbers * math.log(bare.rows)
    drop = bare.cost - refined.cost - cost
    return Candidate(made, drop, cost, refined.hypothesis.effects[-1], None, refined.cost), refined
