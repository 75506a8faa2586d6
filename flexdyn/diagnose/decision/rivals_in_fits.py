"""Fits with another candidate in the place of one that the linear equations can hardly tell from it."""

from __future__ import annotations

import dataclasses
import math

from flexdyn.diagnose.inference.elsewhere import fit_if_likely, log_posterior
from flexdyn.diagnose.inference.passes import Posterior
from flexdyn.diagnose.inference.rivals import EVEN_ODDS_WINDOW
from flexdyn.diagnose.inference.search import OCCAM_WINDOW, Scan
from flexdyn.diagnose.inference.space import Space, Structure
from flexdyn.diagnose.inference.structure_model import hypothesis_of, waits

RIVAL_LOSS = 0.01
"""Share of a candidate's gain by which the linear equations may be wrong: a rival that loses less is fitted [1]."""
LARGEST_LOG_ODDS = 300.0
"""Larger ones are certainty."""


def rivals_in_fits(found: Posterior) -> Posterior:
    """The posterior whose best structure has a rival in it where a fit makes that more likely by more than a mention.

    The linear equations are wrong by the squares of the changes. So they may prefer a candidate to another one that
    moves the rows almost as it does, though a fit with the other one is as good. Each candidate of the best structure
    is replaced by each of these. The odds by fits are kept for the probabilities of names.

    Args:
        found: the posterior, whose best structure is fitted to the equations.
    """
    space, best, made = found.space, found.best, found.fitted
    here = log_posterior(space, best, made)
    whole = frozenset(c for c, _ in best)
    likely, odds = (here + EVEN_ODDS_WINDOW, best, made), list(found.by_fits)
    for structure in _swapped(space, best):
        start = hypothesis_of(space, structure, whole=True)
        value, other = fit_if_likely(space, structure, start, made, here - OCCAM_WINDOW)
        if other is None:
            continue
        odds.append((frozenset(c for c, _ in structure), whole, math.exp(min(value - here, LARGEST_LOG_ODDS))))
        if value > likely[0]:
            likely = (value, structure, other)
    return dataclasses.replace(found, best=likely[1], fitted=likely[2], by_fits=tuple(odds))


def _swapped(space: Space, best: Structure) -> list[Structure]:
    """The best structure with another candidate in the place of one, which keeps nearly all that that one gains."""
    scan, found = Scan(space), []
    for each in sorted(best):
        rest, related = best - {each}, _related(space, each[0])
        lost = RIVAL_LOSS * (space.value(best) - space.value(rest))
        others = [other for gain, other in scan.additions(rest) if gain > 0.0 and not waits(space, other[0])]
        there = [rest | {other} for other in others if other[0] not in related]
        found += [structure for structure in there if space.value(structure) > space.value(best) - lost]
    return found


def _related(space: Space, c: int) -> set[int]:
    """A candidate, and laws at its place that contain it or that it contains: the plainer one of these is told."""
    me = space.candidates[c]
    inside = {*me.law.contains, *me.law.plainer}
    there = [(k, other) for k, other in enumerate(space.candidates) if other.spot == me.spot]
    return {c, *(k for k, each in there if each.kind in inside or me.kind in (*each.law.contains, *each.law.plainer))}
