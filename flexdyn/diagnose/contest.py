"""Several names that the equations cannot tell apart: simulated windows of the fit are asked, which no filter bends."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Sequence
from functools import partial

import numpy as np

from flexdyn.diagnose.abreast import abreast
from flexdyn.diagnose.candidates import ENOUGH, Candidate
from flexdyn.diagnose.refine import Refined, refine
from flexdyn.diagnose.rivals import DOUBT
from flexdyn.diagnose.search import Search
from flexdyn.diagnose.stage import Named, Stage
from flexdyn.diagnose.verify import SURE, confirmed, surely_less
from flexdyn.diagnose.windows import Windows
from flexdyn.effects import Payload

ASKED = 2
"""Rivals of one name that are fitted to windows; more of them stay rivals."""
SHARED = 0.003
"""Share of what windows are off by that means nothing: their noise's linear response is no better than that."""
WORTH = 0.5 * SHARED
"""The same share that a step must promise to be simulated; what it promised is then taken for granted."""
WINDOWS = 48
"""Of the fit, so many are asked, evenly: what tells two names apart is weighed as a share of what all are off by."""
ROUNDS = 2
"""Gauss-Newton steps, all with the slopes of the first: all start where the equations are at their best."""


def contested(search: Search, stage: Stage, windows: Windows) -> Stage:
    """The stage in which a name keeps only those rivals that simulated windows cannot tell from it either.

    Args:
        search: that made the stage.
        stage: its last one.
        windows: of the data of the fit.
    """
    for place, named in enumerate(stage.named):
        if not _is_of(named.candidate, stage):
            continue
        mine = [each for each in named.rivals if _is_of(each, stage)]
        same = [each for each in mine if _alike(each, named.candidate)]
        rivals = [each for each in mine if each not in same]
        if not rivals:
            continue
        entries = [named.candidate, *rivals[:ASKED]]
        asked = _all_asked(search, entries, windows.thinned(WINDOWS))
        least = min(asked, key=_best)
        scale = max(1.0, _best(least) / least.rows)
        costs = [_best(refined) / scale + each.cost for refined, each in zip(asked, entries, strict=True)]
        masses = [cost for cost, each in zip(costs, entries, strict=True) if _is_a_mass(each)]
        # A mass at the tip is that of a link by another name: where one does, the other does.
        costs = [min(c, *masses) if masses and _is_payload(e) else c for c, e in zip(costs, entries, strict=True)]
        over = _best(least) - least.rows - 2.0 * math.sqrt(2.0 * least.rows)
        most = min(costs) + max(ENOUGH, SHARED * _best(least) / scale) + DOUBT * max(over, 0.0) / scale
        best = int(np.argmin(costs))
        # A few windows that hang on whether a joint sticks may say anything: all must agree on what is worse, but for
        # what the file says of its numbers.
        unsure = [surely_less(each.by_window, asked[best].by_window) < SURE for each in asked]
        seen = [max(0.0, float((each.by_window - asked[best].by_window).sum())) / scale for each in asked]
        sure = [cost - more * open_ for cost, more, open_ in zip(costs, seen, unsure, strict=True)]
        stays = [cost <= most for cost in sure]
        winner = 0 if stays[0] else best  # a name stays where nothing speaks for another
        kept = [each for each, stay in zip(entries, stays, strict=True) if stay]
        others = (*(each for each in kept if each is not entries[winner]), *rivals[ASKED:])
        others = (*same, *others) if stays[0] else others
        after = _with(search, stage, place, dataclasses.replace(named, candidate=entries[winner], rivals=others))
        stage = after if winner == 0 or _wanted(search, after) else stage
    return stage


def _best(asked: Refined) -> float:
    """What windows leave, or would after the step that was not simulated."""
    return asked.cost - asked.promised


def _wanted(search: Search, stage: Stage) -> bool:
    """Whether the check wants what came to stand last: it was asked about another name."""
    less = search.stage(*stage.without({len(stage.named) - 1}))
    return confirmed(less.trial, less.fitted, stage.trial, stage.fitted)


def _alike(one: Candidate, other: Candidate) -> bool:
    """Whether one law is a name for the other: both leave the same rows, and windows need not be asked.

    Not where positions are made up: rows that would tell may be left out.
    """
    if one.fitted.equations.made_up.any():
        return False
    left, its = (each.fitted.regression.left[: len(each.fitted.regression.y)] for each in (one, other))
    near = len(left) == len(its) and abs(one.chi2 - other.chi2) < ENOUGH
    return near and float(((left - its) ** 2).sum()) < ENOUGH


def _is_a_mass(candidate: Candidate) -> bool:
    return candidate.number is not None and candidate.number.parameter == "link_mass"


def _is_payload(candidate: Candidate) -> bool:
    return isinstance(candidate.effect, Payload)


def _all_asked(search: Search, entries: Sequence[Candidate], windows: Windows) -> list[Refined]:
    """Contestants fitted to windows, side by side once the slopes of the first one are known."""
    first = _asked(search, entries[0], windows)
    return [first, *abreast(lambda each: _asked(search, each, windows, first), entries[1:])]


def _asked(search: Search, candidate: Candidate, windows: Windows, like: Refined | None = None) -> Refined:
    what = "asking simulated windows"
    hypothesis = candidate.fitted.hypothesis
    temper = search.space.temper
    said = partial(search.say, what)
    return refine(hypothesis, windows, ROUNDS, said, temper, math.inf, like, worth=WORTH)


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
    return search.tried(fitted, (*others, named))
