"""Which effects a model lacks: added one by one, then each made to earn its place beside the others."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial

from flexdyn.diagnose.abreast import abreast
from flexdyn.diagnose.candidates import ENOUGH, Candidate, candidates
from flexdyn.diagnose.estimate import fit
from flexdyn.diagnose.findings import out_of_tolerance
from flexdyn.diagnose.fitted import ROUGH, Fit, Workspace, tempering
from flexdyn.diagnose.hypothesis import Hypothesis
from flexdyn.diagnose.linear import linearised
from flexdyn.diagnose.nesting import is_simpler
from flexdyn.diagnose.refine import of_fit, refine
from flexdyn.diagnose.screen import Screen
from flexdyn.diagnose.stage import Alternative, Named, Stage
from flexdyn.diagnose.verify import EXPLAINED, SURE, Check, Trial, better, confirmed, surely_less
from flexdyn.diagnose.windows import Windows
from flexdyn.effects import Effect, JointElasticity
from flexdyn.effects.model_error import effect_place

MOST = 6
"""Effects that are named at most."""
TRIED = 4
"""Candidates of one round that may fail the check before the search ends."""
LEAST = 0.3
"""Share of what the best candidate takes from which another is tried where the check does not confirm the best."""
DOUBT = 1.0
"""Share of what the best candidate leaves over noise by which another may do worse: its own errors are as large."""
AHEAD = 0.3
"""Share of what is left that an effect must take to be kept in hope, while others hide what it does to the windows."""
HARMLESS = 1.05
"""Factor on the gap of the check by which a choice that explains as much may be worse there."""
HOPES = 2
"""Effects that are kept in hope one after the other."""
REMEMBERED = 12
"""Trials that are kept for when they are asked for again; each holds the response of every window."""
REFINEMENTS = 1
"""Gauss-Newton steps on simulated windows before the check is asked, where equations are rough."""
TEMPERINGS, TEMPERED = 4, 0.1
"""Fits with priors of another weight, until it changes by less than such a share."""


@dataclass(frozen=True, eq=False)
class Search:
    """What all rounds share.

    Attributes:
        space: of the fit.
        screen: of what may be missing.
        check: data that takes no part.
        say: progress.
        windows: of the fit, on which everything is refined before the check is asked, where equations alone are rough.
    """

    space: Workspace
    screen: Screen
    check: Check
    say: Callable[[str, float], None]
    windows: Windows | None = None
    _known: dict[object, Trial] = field(default_factory=dict, repr=False)

    def stage(self, start: Hypothesis, named: tuple[Named, ...] = (), hopeless: float = math.inf) -> Stage:
        """A hypothesis fitted, given up after a few steps where it leaves more than is `hopeless`, and tried."""
        return self.stages([(start, named)], hopeless)[0]

    def stages(self, starts: Sequence[tuple[Hypothesis, tuple[Named, ...]]], hopeless: float = math.inf) -> list[Stage]:
        """The same for hypotheses that do not depend on one another, each with what is named."""
        fits = abreast(lambda start: fit(start[0], self.space, hopeless=hopeless), starts)
        return self.all_tried([(made, named) for made, (_, named) in zip(fits, starts, strict=True)])

    def tried(self, made: Fit, named: tuple[Named, ...] = ()) -> Stage:
        """A fitted hypothesis tried on the check."""
        return self.all_tried([(made, named)])[0]

    def all_tried(self, fits: Sequence[tuple[Fit, tuple[Named, ...]]]) -> list[Stage]:
        """The same for several fits, each with what is named."""
        made = [each for each, _ in fits]
        if self.windows is not None:
            made = abreast(partial(self._refined, self.windows), made)
        trials = self.trials([each.hypothesis for each in made])
        return [Stage(each, trial, named) for each, trial, (_, named) in zip(made, trials, fits, strict=True)]

    def _refined(self, windows: Windows, made: Fit) -> Fit:
        refined = refine(made.hypothesis, windows, REFINEMENTS, temper=self.space.temper)
        return linearised(refined.hypothesis, made.space)

    def trial(self, hypothesis: Hypothesis) -> Trial:
        """On the check; what was tried before is remembered, as the same question comes again."""
        return self.trials([hypothesis])[0]

    def trials(self, hypotheses: Sequence[Hypothesis]) -> list[Trial]:
        """The same for several hypotheses.

        First states are looked for near those of the last one that is known.
        """
        last = next(reversed(self._known.values()), None)
        keys = [(each.effects, each.freed, each.counts, tuple(each.factors.values())) for each in hypotheses]
        found = {key: self._known[key] for key in keys if key in self._known}
        new = {key: each for key, each in zip(keys, hypotheses, strict=True) if key not in found}
        made = abreast(lambda each: self.check.of(each, None if last is None else last.shot), new.values())
        for key, trial in zip(new, made, strict=True):
            if len(self._known) >= REMEMBERED:
                self._known.pop(next(iter(self._known)))
            self._known[key] = found[key] = trial
        return [found[key] for key in keys]

    def tempered(self, stage: Stage) -> tuple[Search, Stage]:
        """The search with priors that weigh against what a stage leaves, and the stage with them."""
        search, made = self, stage.fitted
        for _ in range(TEMPERINGS):
            weight = tempering(made)
            if abs(math.log(weight / search.space.temper)) < TEMPERED:
                break
            search = dataclasses.replace(search, space=dataclasses.replace(search.space, temper=weight))
            made = fit(made.hypothesis.tolerated(), search.space)
        return search, stage if made is stage.fitted else search.tried(made, stage.named)

    def prefers(self, one: Trial, other: Trial) -> bool:
        """Whether the check is surely less off with one, by windows or by equations, and neither says otherwise.

        Where equations are rough, it must be less off by more than any law is.
        """
        if self.windows is not None:
            return better(other, one) > SURE and HARMLESS * one.gap < other.gap
        windows, rows = better(other, one), surely_less(other.rows, one.rows)
        harmless = one.median <= HARMLESS * other.median and rows > -SURE
        return harmless and (windows > SURE or (one.exact and rows > SURE and windows > 0.0))


def forward(search: Search, stages: list[Stage]) -> Search:
    """Add effects until none is wanted any more; `stages` grows meanwhile.

    An effect that the check does not confirm is kept in hope where it takes much of what is left: beside another one
    that is still missing, windows may be as far off with it as without.

    Returns:
        The search with the last stage's weights.
    """
    hopes = 0
    while len(stages[-1].named) < MOST:
        search.say(f"looking for effect {len(stages[-1].named) + 1}", 0.0)
        after, sure = following(search, stages[-1])
        hopes = 0 if sure else hopes + 1
        if after is None or hopes > HOPES:
            break
        if after.fitted.space is not search.space:  # other equations: all begins anew
            stages.append(after)
            break
        if search.windows is not None:
            search, after = search.tempered(after)
        stages.append(after)
    return search


def following(search: Search, now: Stage, ranked: Sequence[Candidate] | None = None) -> tuple[Stage | None, bool]:
    """The best candidate that the check confirms, or one to keep in hope; and whether it was confirmed.

    Args:
        search: that made the stage.
        now: what is named so far.
        ranked: candidates, best first; None: all that are promising.
    """
    ranked = candidates(search.space, search.screen, now.fitted) if ranked is None else ranked
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

    Beside one that leaves noise alone these are such that explain as much; where all leave more, many may be.
    """
    if not ranked:
        return []
    best = ranked[0]
    if best.fitted.reduced < ROUGH:
        return [each for each in ranked if each.behind(best) <= slack(best.fitted)]
    return [each for each in ranked if before.chi2 - each.chi2 > LEAST * (before.chi2 - best.chi2)]


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


def is_rival(other: Candidate, named: Candidate) -> bool:
    """Whether another does without what is named: a number that is surely out of tolerance with both is wrong."""
    return named.number is None or named.number not in out_of_tolerance(of_fit(other.fitted))


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
