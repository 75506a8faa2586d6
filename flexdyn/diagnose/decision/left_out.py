"""Fits without each candidate of the best structure: what the linear equations promise for it must be missed there."""

from __future__ import annotations

import dataclasses
import math

from flexdyn.diagnose.decision.model_effects import effect_of, possible
from flexdyn.diagnose.hypothesis.estimate import fit
from flexdyn.diagnose.hypothesis.hypothesis import Hypothesis
from flexdyn.diagnose.inference.candidate import Candidate
from flexdyn.diagnose.inference.elsewhere import STEPS_ELSEWHERE, STEPS_TRIED, log_posterior
from flexdyn.diagnose.inference.passes import Posterior
from flexdyn.diagnose.inference.search import OCCAM_WINDOW
from flexdyn.errors import SimulationError


def odds_left_out(found: Posterior) -> tuple[tuple[frozenset[int], float], ...]:
    """Sets of the best structure without one candidate, and their odds to it by fits, at most 1.

    The linear equations may promise much for a candidate that takes up the error of another one's linearisation. A fit
    without it then leaves as little. Each begins at the numbers of the best structure's fit and ends early if its next
    step cannot make it likely.

    Args:
        found: the posterior, whose best structure is fitted to the equations.
    """
    space, made = found.space, found.fitted
    here = log_posterior(space, found.best, made)
    odds = []
    for c, p in sorted(found.best):
        rest = found.best - {(c, p)}
        try:
            without = fit(_without(made.hypothesis, space.candidates[c]), made.space, steps=STEPS_TRIED)
        except SimulationError:  # nothing can be computed without it
            continue
        value = log_posterior(space, rest, without)
        if value + 0.5 * (without.reached - without.chi2) > here - OCCAM_WINDOW:
            without = fit(without.hypothesis, made.space, steps=STEPS_ELSEWHERE)
            value = max(value, log_posterior(space, rest, without))
        odds.append((frozenset(each for each, _ in rest), math.exp(min(0.0, value - here))))
    return tuple(odds)


def _without(here: Hypothesis, candidate: Candidate) -> Hypothesis:
    """A hypothesis without what a candidate stands for."""
    if candidate.number is not None:
        return dataclasses.replace(here, freed=here.freed - {candidate.number})
    gone = effect_of(candidate, here)
    return dataclasses.replace(here, effects=possible(here, [each for each in here.effects if each is not gone]))
