"""Fits without each candidate of the best structure: what the linear equations promise for it must be missed there."""

from __future__ import annotations

import dataclasses
import math

from flexdyn.diagnose.constants import OCCAM_WINDOW
from flexdyn.diagnose.decision.fitted_structure import LARGEST_LOG_ODDS
from flexdyn.diagnose.decision.model_effects import without_effect
from flexdyn.diagnose.hypothesis.hypothesis import Hypothesis
from flexdyn.diagnose.inference.candidate import Candidate
from flexdyn.diagnose.inference.passes import Posterior
from flexdyn.diagnose.inference.posterior_of_fit import carried_on, fit_if_likely, log_posterior
from flexdyn.diagnose.inference.space import Structure
from flexdyn.diagnose.inference.structure_model import effect_of


def needed_in_fits(found: Posterior) -> Posterior:
    """The posterior whose best structure has nothing without which a fit is more likely.

    The linear equations may promise much for a candidate that takes up the error of another one's linearisation. A fit
    without it then leaves as little. The candidate without which a fit is most likely is left out, and again, until all
    are missed. A fit that moves numbers of the file beyond their tolerance instead does not count: they imitate the
    candidate. What the equations promise for one that is left out is not believed in other structures either. Every
    structure that was tried keeps its odds: of two candidates of which a fit needs one, "A or B".

    Args:
        found: the posterior, whose best structure is fitted to the equations.
    """
    space, best = found.space, found.best
    made = carried_on(space, best, found.fitted)
    odds: list[tuple[Structure, frozenset[int], float]] = []
    left_out: dict[int, float] = {}
    doubtful = sorted(best)
    while doubtful:
        here = log_posterior(space, best, made)
        whole = frozenset(c for c, _ in best)
        values: dict[tuple[int, int], float] = {}
        least, rest = doubtful[0], None
        for each in doubtful:  # one fit at a time is kept: they are large
            start = _hypothesis_without(made.hypothesis, space.candidates[each[0]])
            values[each], other = fit_if_likely(space, best - {each}, start, made, here - OCCAM_WINDOW)
            if other is not None and other.hypothesis.displaced - made.hypothesis.displaced:
                values[each], other = -math.inf, None  # numbers of the file imitate the candidate
            if values[each] >= values[least] and other is not None:
                least, rest = each, other
        odds += [(best - {x}, whole, math.exp(min(value - here, LARGEST_LOG_ODDS))) for x, value in values.items()]
        if rest is None or values[least] <= here:
            break
        left_out[least[0]] = space.value(best) - space.value(best - {least}) + values[least] - here
        best, made = best - {least}, rest
        doubtful = [each for each in doubtful if each != least and values[each] > here - OCCAM_WINDOW]
    return dataclasses.replace(found, best=best, fitted=made, by_fits=tuple(odds), left_out=left_out)


def _hypothesis_without(here: Hypothesis, candidate: Candidate) -> Hypothesis:
    """A hypothesis without what a candidate stands for."""
    if candidate.number is not None:
        return dataclasses.replace(here, freed=here.freed - {candidate.number})
    return without_effect(here, effect_of(candidate, here))
