"""What else would have done as well as what was named: how near that is, and what others found since say of it."""

from __future__ import annotations

import dataclasses
import math
from functools import partial

from flexdyn.diagnose.abreast import abreast
from flexdyn.diagnose.candidates import ENOUGH, FAR_ABOVE, Candidate
from flexdyn.diagnose.estimate import fit
from flexdyn.diagnose.findings import out_of_tolerance
from flexdyn.diagnose.fitted import Fit
from flexdyn.diagnose.hypothesis import Hypothesis
from flexdyn.diagnose.refine import of_fit
from flexdyn.diagnose.search import HARMLESS, Search
from flexdyn.diagnose.stage import Alternative, Named, Stage
from flexdyn.effects import JointElasticity
from flexdyn.errors import SimulationError

DOUBT = 1.0
"""Share of what the best candidate leaves over noise by which another may do worse: its own errors are as large."""


def is_rival(other: Candidate, named: Candidate) -> bool:
    """Whether another does without what is named: a number that is surely out of tolerance with both is wrong."""
    return named.number is None or named.number not in out_of_tolerance(of_fit(other.fitted))


def slack(best: Fit) -> float:
    """Difference of BIC that says nothing: what is left over noise comes from errors that any law shares."""
    rows = best.regression.rows
    over = best.regression.data_chi2 - rows - 2.0 * math.sqrt(2.0 * rows)
    return ENOUGH + DOUBT * max(over, 0.0) / max(1.0, best.reduced)


def asked_again(search: Search, stage: Stage) -> Stage:
    """Rivals that did as well before the other effects were known stay only where they do so beside them."""
    goal = stage.fitted
    effects = iter(goal.hypothesis.effects)
    named = []
    for each in stage.named:
        effect = next(effects) if each.candidate.number is None else None
        if not each.rivals or each.stays:
            named.append(each)
            continue
        now = dataclasses.replace(each.candidate, fitted=goal, effect=effect, chi2=goal.reached)
        asked = _all_beside(search, stage, each)
        soft = [rival for rival in each.rivals if isinstance(rival.effect, JointElasticity)]  # in equations of its own
        near = [one for one in asked if one.behind(now) <= slack(goal) and is_rival(one, now)]
        named.append(dataclasses.replace(each, candidate=now, rivals=(*near, *soft)))
    return dataclasses.replace(stage, named=tuple(named))


def outdone(search: Search, stage: Stage) -> Stage:
    """The stage with rivals in the places of names that surely do worse beside the one that was found last.

    Asked at once, as what a wrong name leaves would be made up for by others.
    """
    for each in stage.named[:-1]:
        if not each.rivals or each.stays:
            continue
        found = _all_beside(search, stage, each, hopeless=FAR_ABOVE * stage.fitted.chi2)
        asked = sorted(found, key=lambda one: one.chi2 + one.cost)
        old = dataclasses.replace(each.candidate, fitted=stage.fitted, chi2=stage.fitted.reached)
        if not asked or old.behind(asked[0]) <= slack(asked[0].fitted):
            continue
        best = asked[0]
        near = tuple(one for one in asked[1:] if one.behind(best) <= slack(best.fitted) and is_rival(one, best))
        after = search.tried(best.fitted)
        if after.trial.gap > HARMLESS * stage.trial.gap:
            continue
        gaps = {id(best): after.trial.gap, id(old): stage.trial.gap}
        ranked = sorted((*asked, old), key=lambda one: one.behind(best))
        among = (Alternative(one.effect, one.number, one.behind(best), gaps.get(id(one), math.nan)) for one in ranked)
        kept = (one for one in stage.named if one is not each)
        stage = dataclasses.replace(after, named=(*kept, Named(best, near, tuple(among))))
    return stage


def _all_beside(search: Search, stage: Stage, named: Named, hopeless: float = math.inf) -> list[Candidate]:
    """Rivals of a name, each fitted in its place; not those that would need other equations."""
    search.say("asking rivals again", 0.0)
    start, _ = stage.without({stage.named.index(named)})
    rivals = [rival for rival in named.rivals if not isinstance(rival.effect, JointElasticity)]
    made = abreast(partial(_beside, search, start, hopeless=hopeless), rivals)
    return [each for each in made if each is not None]


def _beside(search: Search, start: Hypothesis, rival: Candidate, hopeless: float) -> Candidate | None:
    """A rival fitted again, beside what was found since; None where its equations overflow there."""
    if rival.number is not None:
        start = start.freed_of(rival.number, rival.fitted.hypothesis.factors[rival.number])
    elif rival.effect is not None:
        start = dataclasses.replace(start, effects=(*start.effects, rival.effect))
    try:
        made = fit(start, search.space, hopeless=hopeless)
    except SimulationError:
        return None
    effect = made.hypothesis.effects[-1] if rival.number is None else None
    return dataclasses.replace(rival, fitted=made, effect=effect, chi2=made.reached)
