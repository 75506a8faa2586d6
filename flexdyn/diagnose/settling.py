"""Effects that were added one by one made to earn their place beside the others, or leave it to a better one."""

from __future__ import annotations

import dataclasses
import itertools
from collections.abc import Collection

from flexdyn.diagnose.candidates import FAR_ABOVE, Candidate, candidates
from flexdyn.diagnose.estimate import fit
from flexdyn.diagnose.hypothesis import DISCRETE, kind_and_place
from flexdyn.diagnose.rivals import asked_again, slack
from flexdyn.diagnose.search import HARMLESS, Search
from flexdyn.diagnose.selection import following, forward
from flexdyn.diagnose.stage import Stage
from flexdyn.diagnose.verify import EXPLAINED, confirmed
from flexdyn.diagnose.windows import Windows

PROMISING = 0.3
"""Share of what was unexplained below which effects are asked whether others would do better."""
NEARLY = 0.7
"""Share of what it would have to explain that a linear step must promise for a candidate to be fitted."""
MANY = 3
"""Effects that can each be left out from which all of them are left out together, if that can be as well."""


def again(search: Search, last: Stage, windows: Windows) -> tuple[Search, list[Stage]]:
    """The search taken on, with what rough equations need: priors of their weight, and numbers of simulated windows.

    Args:
        search: that came to an end and left more than noise.
        last: its last stage.
        windows: of the data of the fit.
    """
    start, kept = last.without({k for k, each in enumerate(last.named) if not each.stays})
    search = dataclasses.replace(search, windows=windows)
    _, first = search.tempered(Stage(fit(start, search.space), last.trial, kept))
    search, now = search.tempered(last)
    stages = [first, pruned(search, now)]
    search = forward(search, stages)
    stages.append(pruned(search, stages[-1]))
    return search, stages


def settled(search: Search, first: Stage, stage: Stage) -> Stage:
    """The stage with every effect that still earns its place, and the best for each place beside the others.

    Many effects that together leave much are not worth that: none of their names will stand.

    Args:
        search: that made the stages.
        first: without any effect.
        stage: the last one.
    """
    stage = pruned(search, stage)
    good = stage.trial.excess < PROMISING * first.trial.excess or stage.trial.median < EXPLAINED
    older = any(not each.stays and each.candidate.fitted.space is not search.space for each in stage.named)
    if good and (len(stage.named) > 1 or older):  # other noise by now, or other effects
        stage = asked_again(search, _merged(search, _exchanged(search, stage)))
    return stage


def pruned(search: Search, stage: Stage) -> Stage:
    """Effects that the check does not miss are taken out, the weakest first; many of them at once, if it can be."""
    while stage.named:
        search.say("asking what can be left out", 0.0)
        places = [k for k, each in enumerate(stage.named) if not each.stays]
        hopeless = FAR_ABOVE * stage.fitted.chi2
        less = dict(zip(places, search.stages([stage.without({k}) for k in places], hopeless), strict=True))
        idle = [k for k in places if not _missed(less[k], stage)]
        if not idle:
            break
        if len(idle) >= MANY:
            bare = search.stage(*stage.without(idle))
            if not _missed(bare, stage):
                stage = bare
                continue
        stage = min((less[k] for k in idle), key=lambda each: each.fitted.chi2)
    return stage


def _missed(less: Stage, stage: Stage) -> bool:
    """Whether the check wants what one stage has more than the other."""
    return confirmed(less.trial, less.fitted, stage.trial, stage.fitted)


def _exchanged(search: Search, stage: Stage) -> Stage:
    """Each effect chosen anew beside the others: what hid the right one when it was chosen may be known by now.

    Others may have been there only to make up for the wrong one.
    """
    for old in [each for each in stage.named if not each.stays]:
        search.say("choosing again beside the others", 0.0)
        after = next((_instead(search, stage, {k}) for k, each in enumerate(stage.named) if each is old), None)
        stage = stage if after is None else pruned(search, after)
    return stage


def _merged(search: Search, stage: Stage) -> Stage:
    """Two effects of one place that a single one explains as well are that one."""
    for i, j in itertools.combinations(range(len(stage.named)), 2):
        if stage.named[i].joint != stage.named[j].joint or stage.named[i].stays or stage.named[j].stays:
            continue
        search.say("asking whether one does for two", 0.0)
        after = _instead(search, stage, {i, j})
        if after is not None:
            return _merged(search, after)
    return stage


def _instead(search: Search, stage: Stage, gone: Collection[int]) -> Stage | None:
    """The stage with one effect for some of what was named, if it explains the fit as well and the check no worse."""
    start, kept = stage.without(gone)
    goal = stage.fitted
    most = goal.chi2 + slack(goal)
    made = fit(start, search.space, hopeless=FAR_ABOVE * most)
    ranked = candidates(search.space, search.screen, made, NEARLY * (made.chi2 - goal.chi2), most)
    ranked = [each for each in ranked if each.chi2 <= most]
    if not any(_what(each) not in {_what(stage.named[k].candidate) for k in gone} for each in ranked):
        return None
    after, sure = following(search, search.tried(made, kept), ranked)
    return after if after is not None and sure and after.trial.gap <= HARMLESS * stage.trial.gap else None


def _what(candidate: Candidate) -> tuple[object, ...]:
    """Kind, place and counted parameters of an effect, or the number that is set free."""
    counted = tuple(getattr(candidate.effect, name, None) for name in DISCRETE)
    return (candidate.number, *kind_and_place(candidate.effect), *counted)
