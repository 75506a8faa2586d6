"""Which effects a model lacks: added one by one, then each made to earn its place beside the others."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping, Sequence

from flexdyn.diagnose.candidates import Candidate, candidates
from flexdyn.diagnose.findings import out_of_tolerance
from flexdyn.diagnose.fitted import ROUGH, Fit
from flexdyn.diagnose.nesting import is_simpler
from flexdyn.diagnose.refine import of_fit
from flexdyn.diagnose.rivals import is_rival, outdone, slack
from flexdyn.diagnose.search import Search
from flexdyn.diagnose.stage import Alternative, Named, Stage
from flexdyn.diagnose.standing import explained
from flexdyn.diagnose.verify import EXPLAINED, SURE, confirmed, surely_less
from flexdyn.effects import Effect, JointElasticity
from flexdyn.effects.model_error import effect_place

MOST = 6
"""Effects that are named at most."""
TRIED = 4
"""Candidates of one round that may fail the check before the search ends."""
LEAST = 0.3
"""Share of what the best candidate takes from which another is tried where the check does not confirm the best."""
AHEAD = 0.3
"""Share of what is left that an effect must take to be kept in hope, while others hide what it does to the windows."""
HOPES = 2
"""Effects that are kept in hope one after the other."""
SLIGHT = 0.05
"""Share of what equations leave that a linear step must promise where windows are at noise and filters, not noise,
limit equations: any law takes some of what filters bend, and windows notice."""


def forward(search: Search, stages: list[Stage]) -> Search:
    """Add effects until none is wanted any more; `stages` grows meanwhile.

    An effect that the check does not confirm is kept in hope where it takes much of what is left: beside another one
    that is still missing, windows may be as far off with it as without.

    Returns:
        The search with the last stage's weights.
    """
    hopes = 0
    while len(stages[-1].named) < MOST:
        now = stages[-1]
        search.say(f"looking for effect {len(now.named) + 1}", 0.0)
        ranked = candidates(search.space, search.screen, now.fitted, _least(stages[0], now))
        after, sure = following(search, now, ranked)
        hopes = 0 if sure else hopes + 1
        if after is None or hopes > HOPES:
            break
        if after.fitted.space is not search.space:  # other equations: all begins anew
            stages.append(after)
            break
        if search.windows is not None:
            search, after = search.tempered(after)
        stages.append(outdone(search, after))
    return search


def _least(first: Stage, now: Stage) -> float:
    """Drop of chi^2 that the next effect must promise to be asked about."""
    made = now.fitted
    if made.reduced < ROUGH or not now.named or not explained(now, first):
        return 0.0
    return SLIGHT * (made.regression.data_chi2 - made.regression.rows)


def following(search: Search, now: Stage, ranked: Sequence[Candidate]) -> tuple[Stage | None, bool]:
    """The best candidate that the check confirms, or one to keep in hope; and whether it was confirmed.

    Args:
        search: that made the stage.
        now: what is named so far.
        ranked: candidates, best first.
    """
    if search.windows is not None:  # what is rigid and what is not has been decided by then
        ranked = [each for each in ranked if not isinstance(each.effect, JointElasticity)]
    hope: Stage | None = None
    gaps: dict[int, float] = {}
    for candidate in _worth_a_try(now.fitted, ranked)[:TRIED]:
        stage = search.tried(candidate.fitted)
        trial, gaps[id(candidate)] = stage.trial, stage.trial.gap
        named = Named(candidate, among=_among(ranked, candidate, gaps))
        stage = dataclasses.replace(stage, named=(*now.named, named))
        if confirmed(now.trial, now.fitted, trial, candidate.fitted):
            return _chosen(search, now, ranked, stage, gaps), True
        rough = now.trial.median > EXPLAINED
        much = trial.excess < (1.0 - AHEAD) * now.trial.excess
        if hope is None and rough and much and surely_less(now.trial.rows, trial.rows) > SURE:
            hope = stage
    return hope, False


def _worth_a_try(before: Fit, ranked: Sequence[Candidate]) -> list[Candidate]:
    """The best candidate, and those that might be the truth if the check does not confirm it.

    Beside one that leaves noise alone these are such that explain as much; where all leave more, many may be, and of
    the file's numbers every one that was bent beyond its tolerance.
    """
    if not ranked:
        return []
    best = ranked[0]
    if best.fitted.reduced < ROUGH:
        return [each for each in ranked if each.behind(best) <= slack(best.fitted)]
    much, bent = LEAST * (before.chi2 - best.chi2), out_of_tolerance(of_fit(before))
    return [each for each in ranked if before.chi2 - each.chi2 > much or each.number in bent]


def _chosen(search: Search, now: Stage, ranked: Sequence[Candidate], stage: Stage, gaps: dict[int, float]) -> Stage:
    """Of a confirmed candidate and those that do as well the plainest, of these the one that the check likes best.

    It must want that one as well.

    One that contains another stays where the check surely needs what it has more.
    """
    best = stage.named[-1].candidate
    near = [best, *(other for other in ranked if other is not best and other.behind(best) <= slack(best.fitted))]
    also = search.all_tried([(each.fitted, ()) for each in near[1:]])
    tried = {id(each): made for each, made in zip(near, (stage, *also), strict=True)}
    of = {key: each.trial for key, each in tried.items()}
    plain = [each for each in near if all(search.prefers(of[id(each)], of[id(e)]) for e in near if contains(each, e))]
    trials = [of[id(each)] for each in plain]
    gaps.update({key: trial.gap for key, trial in of.items()})
    wanted = [each is best or confirmed(now.trial, now.fitted, of[id(each)], each.fitted) for each in plain]
    first = wanted.index(True) if any(wanted) else 0
    for k, trial in enumerate(trials):
        if wanted[k] and search.prefers(trial, trials[first]):
            first = k
    rivals = [each for each, trial in zip(plain, trials, strict=True) if not search.prefers(trials[first], trial)]
    named = plain[first]
    others = tuple(each for each in rivals if each is not named and is_rival(each, named))
    last = Named(named, others, _among(ranked, named, gaps))
    return dataclasses.replace(tried[id(named)], named=(*now.named, last))


def _among(ranked: Sequence[Candidate], best: Candidate, gaps: Mapping[int, float]) -> tuple[Alternative, ...]:
    """The candidates of a round as they compare with the one that was chosen."""
    return tuple(
        Alternative(each.effect, each.number, each.behind(best), gaps.get(id(each), math.nan)) for each in ranked
    )


def contains(one: Candidate, other: Candidate) -> bool:
    """Whether one effect becomes another of the same place in a limit, or a change of what is there already."""
    simpler = _changed(other) if other.number is not None else other.effect
    if one.effect is None or simpler is None:
        return False
    same = all(getattr(one.effect, key, None) == getattr(simpler, key, None) for key in ("joint", "side"))
    return same and is_simpler(simpler.name, one.effect.name)


def _changed(candidate: Candidate) -> Effect | None:
    """The effect of the file that a number set free belongs to; None: it is a joint's or a link's."""
    place = effect_place(candidate.number.of) if candidate.number is not None else None
    return None if place is None else candidate.fitted.hypothesis.given.effects[place]
