"""What all rounds of a search share: hypotheses fitted to the equations and tried on data that takes no part."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import partial

from flexdyn.diagnose.abreast import abreast
from flexdyn.diagnose.estimate import fit
from flexdyn.diagnose.fitted import Fit, Workspace, tempering
from flexdyn.diagnose.hypothesis import Hypothesis
from flexdyn.diagnose.linear import linearised
from flexdyn.diagnose.refine import refine
from flexdyn.diagnose.screen import Screen
from flexdyn.diagnose.stage import Named, Stage
from flexdyn.diagnose.verify import SURE, Check, Trial, better, surely_less
from flexdyn.diagnose.windows import Windows

HARMLESS = 1.05
"""Factor on the gap of the check by which a choice that explains as much may be worse there."""
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
            made = fit(made.hypothesis, search.space)
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
