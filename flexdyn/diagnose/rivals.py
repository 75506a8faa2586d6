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
    for k, each in enumerate(stage.named):
        effect = next(effects) if each.candidate.number is None else None
        if not each.rivals or each.stays:
            named.append(each)
            continue
        search.say("asking rivals again", 0.0)
        now = dataclasses.replace(each.candidate, fitted=goal, effect=effect, chi2=goal.reached)
        start = stage.without({k})[0]
        soft = [rival for rival in each.rivals if isinstance(rival.effect, JointElasticity)]  # in equations of its own
        asked = [_beside(search, start, rival) for rival in each.rivals if rival not in soft]
        near = [one for one in asked if one is not None and one.behind(now) <= slack(goal) and is_rival(one, now)]
        named.append(dataclasses.replace(each, candidate=now, rivals=(*near, *soft)))
    return dataclasses.replace(stage, named=tuple(named))


def outdone(search: Search, stage: Stage) -> Stage:
    """The stage with rivals in the places of names that surely do worse beside the one that was found last.

    Asked at once, as what a wrong name leaves would be made up for by others.
    """
    for each in stage.named[:-1]:
        rivals = [rival for rival in each.rivals if not isinstance(rival.effect, JointElasticity)]
        if not rivals or each.stays:
            continue
        search.say("asking rivals again", 0.0)
        start, kept = stage.without({stage.named.index(each)})
        made = abreast(partial(_beside, search, start, hopeless=FAR_ABOVE * stage.fitted.chi2), rivals)
        asked = sorted((one for one in made if one is not None), key=lambda one: one.chi2 + one.cost)
        old = dataclasses.replace(each.candidate, fitted=stage.fitted, chi2=stage.fitted.reached)
        if not asked or old.behind(asked[0]) <= slack(asked[0].fitted):
            continue
        best = asked[0]
        near = tuple(one for one in asked[1:] if one.behind(best) <= slack(best.fitted) and is_rival(one, best))
        among = tuple(Alternative(one.effect, one.number, one.behind(best), math.nan) for one in (*asked, old))
        after = search.tried(best.fitted, (*kept, Named(best, near, among)))
        stage = after if after.trial.gap <= HARMLESS * stage.trial.gap else stage
    return stage


def _beside(search: Search, start: Hypothesis, rival: Candidate, *, hopeless: float = math.inf) -> Candidate | None:
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
