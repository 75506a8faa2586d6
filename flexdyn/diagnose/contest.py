"""Several names that the equations cannot tell apart: simulated windows of the fit are asked, which no filter bends."""

from __future__ import annotations

import math

from flexdyn.diagnose.refine import Refined, refine
from flexdyn.diagnose.search import ENOUGH, Candidate
from flexdyn.diagnose.selection import DOUBT, Search
from flexdyn.diagnose.stage import Named, Stage
from flexdyn.diagnose.windows import Windows

ASKED = 2
"""Rivals of one name that are fitted to windows; more of them stay rivals."""
ROUNDS = 2
"""Gauss-Newton steps: all start where the equations are at their best."""


def contested(search: Search, stage: Stage, windows: Windows) -> Stage:
    """The stage in which a name keeps only those rivals that simulated windows cannot tell from it either.

    Args:
        search: that made the stage.
        stage: its last one.
        windows: of the data of the fit.
    """
    for place, named in enumerate(stage.named):
        rivals = [each for each in named.rivals if _is_of(each, stage)]
        if not rivals or not _is_of(named.candidate, stage):
            continue
        tried = [(_asked(search, each, windows), each) for each in (named.candidate, *rivals[:ASKED])]
        tried.sort(key=lambda pair: pair[0].cost + pair[1].cost)
        winner, best = tried[0]
        scale = max(1.0, winner.cost / winner.rows)
        least = ENOUGH + DOUBT * max(winner.cost - winner.rows - 2.0 * math.sqrt(2.0 * winner.rows), 0.0) / scale
        kept = [
            each for refined, each in tried[1:] if (refined.cost - winner.cost) / scale + each.cost - best.cost <= least
        ]
        stage = _with(search, stage, place, Named(best, (*kept, *rivals[ASKED:]), named.among))
    return stage


def _asked(search: Search, candidate: Candidate, windows: Windows) -> Refined:
    what = "asking simulated windows"
    hypothesis = candidate.fitted.hypothesis
    return refine(hypothesis, windows, ROUNDS, progress=lambda share: search.say(what, share))


def _is_of(candidate: Candidate, stage: Stage) -> bool:
    """Whether a candidate was fitted beside all the others that are named."""
    mine, its = (each.hypothesis for each in (candidate.fitted, stage.fitted))
    return len(mine.effects) + len(mine.freed) == len(its.effects) + len(its.freed)


def _with(search: Search, stage: Stage, place: int, named: Named) -> Stage:
    """The stage with another name at a place, which comes to stand last."""
    others = tuple(each for k, each in enumerate(stage.named) if k != place)
    if named.candidate is stage.named[place].candidate:
        return Stage(stage.fitted, stage.trial, tuple(named if k == place else e for k, e in enumerate(stage.named)))
    fitted = named.candidate.fitted
    return Stage(fitted, search.check.of(fitted.hypothesis), (*others, named))
