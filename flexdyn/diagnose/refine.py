"""The final fit: a hypothesis against simulated windows, and how far its numbers can be trusted."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from functools import partial

import numpy as np
from numpy.typing import NDArray

from flexdyn.diagnose.fitted import Fit
from flexdyn.diagnose.gap import Shot, shoot
from flexdyn.diagnose.hypothesis import Hypothesis, moved
from flexdyn.diagnose.numbers import FileNumber
from flexdyn.diagnose.slopes import ROBUST, Known, Slopes, size, slopes_of, weights
from flexdyn.diagnose.windows import Windows
from flexdyn.effects import Effect

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Refined:
    """A hypothesis fitted to windows.

    Attributes:
        hypothesis: with its numbers at their best.
        std: of the file's numbers' factors, then of the effects' unknowns in their own unit.
        cost: robust sum of squares of the windows' white surprises and of the priors; NaN where none were simulated.
        rows: white surprises that it is of.
        by_window: that sum for every window, without the priors (windows,).
        became: names of effects that turned out to be simpler ones.
        slopes: that were taken last; None where none were.
        shot: the windows at their best; None where none were simulated.
        promised: drop of the cost by a step that was not worth its time.
    """

    hypothesis: Hypothesis
    std: Array
    cost: float = math.nan
    rows: int = 0
    by_window: Array = field(default_factory=lambda: np.zeros(0), repr=False)
    became: Mapping[str, str] = field(default_factory=dict)
    slopes: Slopes | None = field(default=None, repr=False)
    shot: Shot | None = field(default=None, repr=False)
    promised: float = 0.0

    def factor_std(self) -> dict[FileNumber, float]:
        """Standard deviations of the file's numbers' factors."""
        return {number: float(s) for number, s in zip(self.hypothesis.factors, self.std, strict=False)}

    def matching(self, effect: Effect | None) -> Effect | None:
        """The effect of the same name at the same place, or the simpler one that it became."""
        places = ("joint", "side", "channel", "other", "frame")
        name = getattr(effect, "name", "")
        for each in self.hypothesis.effects:
            there = all(getattr(each, key, None) == getattr(effect, key, None) for key in places)
            if there and each.name in (name, self.became.get(name)):
                return each
        return None

    def renamed(self, changes: Mapping[Effect, Effect]) -> Refined:
        """The same fit with effects replaced; numbers of the same meaning keep their order and spread."""
        old = self.effect_std()
        effects = tuple(changes.get(e, e) for e in self.hypothesis.effects)
        hypothesis = dataclasses.replace(self.hypothesis, effects=effects)
        origin = {new: e for e, new in changes.items()}
        own = []
        for effect, name in hypothesis.unknowns():
            source = origin.get(effect, effect)
            spread = old.get((source, name))
            own.append(
                spread if spread is not None else max((s for (e, _), s in old.items() if e is source), default=0.0)
            )
        std = np.concatenate([self.std[: len(self.hypothesis.factors)], own])
        became = {e.name: new.name for e, new in changes.items() if e.name != new.name}
        return dataclasses.replace(self, hypothesis=hypothesis, std=std, became=became)

    def effect_std(self) -> dict[tuple[Effect, str], float]:
        """Standard deviations of the effects' unknowns."""
        own = self.std[len(self.hypothesis.factors) :]
        return {key: float(s) for key, s in zip(self.hypothesis.unknowns(), own, strict=True)}


def of_fit(made: Fit) -> Refined:
    """The numbers of a fit to the equations."""
    return Refined(made.hypothesis, np.array([*made.factor_std().values(), *made.std().values()]))


def refine(
    start: Hypothesis,
    windows: Windows,
    rounds: int = 3,
    progress: Callable[[float], None] | None = None,
    temper: float = 1.0,
    anew: float = 0.0,
    like: Refined | None = None,
    worth: float = 0.0,
) -> Refined:
    """Gauss-Newton on the whitened surprises of simulated windows, with the priors of the file's numbers.

    Standard deviations come from a sandwich over windows, so that they hold for residuals that are coloured within one.

    Args:
        start: where to begin.
        windows: that are simulated.
        rounds: at most so many steps.
        progress: called with the share that is done.
        temper: factor on the priors.
        anew: slopes, each a simulation for every number, are kept while no number moves by more than this share of
            its size; 0: never, infinity: always.
        like: another hypothesis that was fitted to the same windows and explains them nearly as well: its slopes of
            the file's numbers will do.
        worth: share of the cost below which a drop that a step promises is not worth simulating it.
    """
    current = start
    shot = shoot(current.seen(), windows, None if like is None else like.shot)
    best = _cost(current, shot, temper)
    std = np.zeros(len(current.factors) + len(current.unknowns()))
    taken: Hypothesis | None = None
    known: Known = {} if like is None or like.slopes is None else like.slopes.of_numbers
    slopes: Slopes | None = None
    for k in range(rounds if math.isfinite(best) else 0):
        if slopes is None or taken is None or _apart(taken, current) > anew:
            said = progress and partial(_between, progress, k / rounds, (k + 1) / rounds)
            slopes, taken, known = slopes_of(current, shot, temper, said, known), current, {}
        else:
            slopes = dataclasses.replace(slopes, weight=weights(shot.whitened()))
        std = slopes.std(shot)
        promised = slopes.promised(shot, current)
        if promised < worth * best:
            return Refined(current, std, best, *_rows_of(shot), slopes=slopes, shot=shot, promised=promised)
        gained = 0.0
        for trial in _trials(current, shot, slopes, windows):
            cost = _cost(*trial, temper)
            if cost < best:
                gained, best = best - cost, cost
                current, shot = trial
                break
        if gained < 1e-3 * best:
            break
    return Refined(current, std, best, *_rows_of(shot), slopes=slopes, shot=shot)


def _rows_of(shot: Shot) -> tuple[int, Array]:
    """How many surprises there are, and their robust sum of squares of every window (windows,)."""
    return shot.whitened().size, _by_window(shot)


def _between(progress: Callable[[float], None], low: float, high: float, share: float) -> None:
    """Progress of a part."""
    progress(low + (high - low) * share)


def _trials(current: Hypothesis, shot: Shot, slopes: Slopes, windows: Windows) -> Iterator[tuple[Hypothesis, Shot]]:
    """A full step, the same after another one with the same slopes from there, and a third of the step.

    Numbers that multiply one another lie along a bent valley, whose floor a straight step leaves.
    """
    step = slopes.step(shot, current)
    there = moved(current, step, slopes.scales)
    seen = shoot(there.seen(), windows, shot, shot.fragile)
    yield there, seen
    if np.isfinite(seen.whitened()).all():
        there = moved(there, slopes.step(seen, there), slopes.scales)
        yield there, shoot(there.seen(), windows, seen, shot.fragile)
    there = moved(current, 0.3 * step, slopes.scales)
    yield there, shoot(there.seen(), windows, shot, shot.fragile)


def _apart(one: Hypothesis, other: Hypothesis) -> float:
    """How far a number has moved at most, by its size."""
    factors = (abs(other.factors[number] - factor) for number, factor in one.factors.items())
    unknowns = zip(one.unknowns(), other.unknowns(), strict=True)
    moves = (abs(getattr(b, name) - getattr(a, name)) / size(a, name) for (a, name), (b, _) in unknowns)
    return float(max([0.0, *factors, *moves]))


def _cost(hypothesis: Hypothesis, shot: Shot, temper: float) -> float:
    """Robust sum of squares of surprises and priors."""
    prior = sum(
        ((f - 1.0) / max(n.tolerance, 1e-9)) ** 2 for n, f in hypothesis.factors.items() if n not in hypothesis.freed
    )
    return float(_by_window(shot).sum() + temper * prior)


def _by_window(shot: Shot) -> Array:
    """Robust sum of squares of the surprises of every window (windows,)."""
    return np.asarray((ROBUST**2 * np.log1p((shot.whitened() / ROBUST) ** 2)).sum(axis=1))
