"""Which effects a model lacks: added one by one, then each made to earn its place beside the others."""

from __future__ import annotations

import dataclasses
import itertools
import math
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass

from flexdyn.diagnose.estimate import Fit, Hypothesis, Workspace, fit
from flexdyn.diagnose.nesting import is_simpler
from flexdyn.diagnose.search import ENOUGH, Candidate, Screen, candidates
from flexdyn.diagnose.stage import Alternative, Named, Stage
from flexdyn.diagnose.verify import EXPLAINED, SURE, Check, better, confirmed, significance

MOST = 6
"""Effects that are named at most."""
TRIED = 4
"""Candidates of one round that may fail the check before the search ends."""
LEAST = 0.3
"""Share of the best candidate's drop from which another is tried where the check does not confirm the best."""
DOUBT = 0.5
"""Share of what the best candidate leaves over noise by which another may do worse: its own errors are as large."""
AHEAD = 0.3
"""Share of what is left that an effect must take to be kept in hope, while others hide what it does to the windows."""
HOPES = 2
"""Effects that are kept in hope one after the other."""


@dataclass(frozen=True, eq=False)
class Search:
    """What all rounds share."""

    space: Workspace
    screen: Screen
    check: Check
    say: Callable[[str, float], None]

    def stage(self, start: Hypothesis, named: tuple[Named, ...] = ()) -> Stage:
        """A hypothesis fitted and tried."""
        made = fit(start, self.space)
        return Stage(made, self.check.of(made.hypothesis), named)


def forward(search: Search, stages: list[Stage]) -> None:
    """Add effects until none is wanted any more; `stages` grows meanwhile.

    An effect that the check does not confirm is kept in hope where it takes much of what is left: beside another one
    that is still missing, windows may be as far off with it as without.
    """
    hopes = 0
    while len(stages[-1].named) < MOST:
        search.say(f"looking for effect {len(stages[-1].named) + 1}", 0.0)
        after, sure = following(search, stages[-1])
        hopes = 0 if sure else hopes + 1
        if after is None or hopes > HOPES:
            return
        stages.append(after)
        if after.fitted.space is not search.space:  # other equations: all begins anew
            return


def following(search: Search, now: Stage) -> tuple[Stage | None, bool]:
    """The best candidate that the check confirms, or one to keep in hope; and whether it was confirmed."""
    ranked = candidates(search.space, search.screen, now.fitted)
    hope: Stage | None = None
    gaps: dict[int, float] = {}
    for candidate in [each for each in ranked if each.drop > LEAST * ranked[0].drop][:TRIED]:
        trial = search.check.of(candidate.fitted.hypothesis)
        gaps[id(candidate)] = trial.gap
        stage = Stage(candidate.fitted, trial, (*now.named, Named(candidate, among=_among(ranked, candidate, gaps))))
        if confirmed(now.trial, now.fitted, trial, candidate.fitted):
            return _chosen(search, now, ranked, stage, gaps), True
        rough = now.trial.median > EXPLAINED
        much = trial.excess < (1.0 - AHEAD) * now.trial.excess
        if hope is None and rough and much and significance(now.trial.rows - trial.rows) > SURE:
            hope = stage
    return hope, False


def _chosen(search: Search, now: Stage, ranked: Sequence[Candidate], stage: Stage, gaps: dict[int, float]) -> Stage:
    """A confirmed stage with the candidates that do as well as its own; the plainest of those that contain others."""
    best = stage.named[-1].candidate
    near = [other for other in ranked if other is not best and other.behind(best) <= slack(best.fitted)]
    for other in near:
        if contains(best, other):
            trial = search.check.of(other.fitted.hypothesis)
            gaps[id(other)] = trial.gap
            return Stage(other.fitted, trial, (*now.named, Named(other, among=_among(ranked, other, gaps))))
    rivals = []
    for other in near:
        trial = search.check.of(other.fitted.hypothesis)
        gaps[id(other)] = trial.gap
        plain = not contains(other, best) and not any(contains(other, each) for each in near)
        if plain and better(trial, stage.trial) < SURE:
            rivals.append(other)
    return dataclasses.replace(stage, named=(*now.named, Named(best, tuple(rivals), _among(ranked, best, gaps))))


def _among(ranked: Sequence[Candidate], best: Candidate, gaps: Mapping[int, float]) -> tuple[Alternative, ...]:
    """The candidates of a round as they compare with the one that was chosen."""
    return tuple(
        Alternative(each.effect, each.number, each.behind(best), gaps.get(id(each), math.nan)) for each in ranked
    )


def slack(best: Fit) -> float:
    """Difference of BIC that says nothing: what is left over noise comes from errors that any law shares."""
    rows = best.regression.rows
    over = best.regression.data_chi2 - rows - 2.0 * math.sqrt(2.0 * rows)
    return ENOUGH + DOUBT * max(over, 0.0) / max(1.0, best.reduced)


def contains(one: Candidate, other: Candidate) -> bool:
    """Whether one effect becomes another of the same place in a limit."""
    if one.effect is None or other.effect is None:
        return False
    same = all(getattr(one.effect, key, None) == getattr(other.effect, key, None) for key in ("joint", "side"))
    return same and is_simpler(other.effect.name, one.effect.name)


def settled(search: Search, stage: Stage) -> Stage:
    """The stage with every effect that still earns its place, and the best for each place beside the others."""
    stage = pruned(search, stage)
    if len(stage.named) > 1:
        stage = _merged(search, _exchanged(search, stage))
    return stage


def pruned(search: Search, stage: Stage) -> Stage:
    """Effects that the check does not miss are taken out, the weakest first."""
    while stage.named:
        search.say("asking what can be left out", 0.0)
        less = [_less(search, stage, {k}) for k, each in enumerate(stage.named) if not each.stays]
        idle = [each for each in less if not confirmed(each.trial, each.fitted, stage.trial, stage.fitted)]
        if not idle:
            break
        stage = min(idle, key=lambda each: each.fitted.chi2)
    return stage


def _less(search: Search, stage: Stage, gone: Collection[int]) -> Stage:
    """The stage without some of what was named."""
    return search.stage(*stage.without(gone))


def _exchanged(search: Search, stage: Stage) -> Stage:
    """Each effect chosen anew beside the others: what hid the right one when it was chosen may be known by now."""
    for old in [each for each in stage.named if not each.stays]:
        search.say("choosing again beside the others", 0.0)
        place = next(k for k, each in enumerate(stage.named) if each is old)
        after, sure = following(search, _less(search, stage, {place}))
        if after is not None and sure and after.fitted.chi2 <= stage.fitted.chi2 + slack(stage.fitted):
            stage = after
    return stage


def _merged(search: Search, stage: Stage) -> Stage:
    """Two effects of one place that a single one explains as well are that one."""
    for i, j in itertools.combinations(range(len(stage.named)), 2):
        if stage.named[i].joint != stage.named[j].joint or stage.named[i].stays or stage.named[j].stays:
            continue
        search.say("asking whether one does for two", 0.0)
        after, sure = following(search, _less(search, stage, {i, j}))
        if after is not None and sure and after.fitted.chi2 <= stage.fitted.chi2 + slack(stage.fitted):
            return _merged(search, after)
    return stage
