"""Structures over simulated windows: each with its fit and its log posterior, and the search among them."""

from __future__ import annotations

import contextlib
import math

import numpy as np

from flexdyn.diagnose.constants import STRONG_GAIN_SHARE
from flexdyn.diagnose.hypothesis.estimate import fit
from flexdyn.diagnose.hypothesis.fitted import Fit
from flexdyn.diagnose.inference.passes import Posterior
from flexdyn.diagnose.inference.scan import Scan
from flexdyn.diagnose.inference.space import Structure
from flexdyn.diagnose.inference.structure_model import hypothesis_of, waits
from flexdyn.diagnose.shooting.gap import Shot
from flexdyn.diagnose.shooting.windows import Windows
from flexdyn.diagnose.simulated.window_fit import WindowFit, fit_to_windows, searched, unlike_noise
from flexdyn.diagnose.simulated.window_scan import Addition, Responses, is_asked, promising
from flexdyn.errors import FlexdynError

SWAPS, ADDITIONS = 2, 2
"""Candidates that are tried in the place of each one, and beside all: so many by the equations, so many by windows, and
so many of those of which windows say nothing before they are simulated."""
LARGEST_QUESTIONED = 4
"""Candidates of a structure, at most, whose neighbours are simulated: larger ones imitate what the catalogue lacks."""
SEARCH_ROUNDS = 3
"""Structures whose neighbours are compared, at most."""
RIVALS_SIMULATED = 8
"""Candidates that are simulated in the place of each one of the structure that the equations prefer, at most."""
FITTED_SWAPS = 2
"""Swaps whose numbers are fitted to the windows: those that are nearest before."""
EQUATIONS_FIT_STEPS = 6
"""Steps of the fit to the equations, with a warm start at the linear estimate."""


class Simulated:
    """Structures that were simulated, each with its log posterior.

    The likelihood is that of the windows instead of the equations; priors and volumes are the same. Sizes of effects do
    not count, as the equations may say nothing of them.

    Args:
        found: the posterior by the equations.
        windows: of the data of the fit.
    """

    def __init__(self, found: Posterior, windows: Windows) -> None:
        self.found, self.windows = found, windows
        self.fits: dict[Structure, WindowFit] = {}
        self._weighed: dict[Structure, tuple[float, float, bool]] = {}
        self.tried: set[Structure] = set()
        self.fitted: set[Structure] = set()
        self.promised: dict[Structure, list[Addition]] = {}
        self.responses: Responses = {}

    def start(self, structure: Structure) -> None:
        """Simulate with the numbers of the equations; a structure that cannot be simulated is left out."""
        if structure in self.fits or self._lacking_springs(structure) - self._lacking_springs(self.found.best):
            return
        with contextlib.suppress(FlexdynError):
            self._take(structure, WindowFit.of(self.by_equations(structure), self.windows))

    def _lacking_springs(self, structure: Structure) -> set[str]:
        """Rigid joints on which friction takes the load, without the elasticity that it needs.

        A hypothesis gets one all the same. Fitted to windows it would be a number for which nothing is paid.
        """
        space = self.found.space
        each = [space.candidates[c] for c, _ in structure]
        loaded = {space.candidates[c].place["joint"] for c, _ in structure if waits(space, c)}
        return loaded - {one.place["joint"] for one in each if one.law.makes_elastic}

    def by_equations(self, structure: Structure) -> Fit:
        """A structure with the numbers of the equations."""
        if structure == self.found.best:
            return self.found.fitted
        here = hypothesis_of(self.found.space, structure, whole=True)
        return fit(here, self.found.fitted.space, steps=EQUATIONS_FIT_STEPS)

    def start_with(self, base: Structure, more: Addition) -> None:
        """Simulate a structure that was fitted with one candidate more."""
        structure = base | {more.point}
        if structure not in self.fits:
            with contextlib.suppress(FlexdynError):
                number = self.found.space.candidates[more.point[0]].number
                tried = [self.fits[base].with_one_more(effect, number, step) for step, effect in more.tried]
                self._take(structure, max(tried, key=lambda each: each.log_posterior))

    def fit(self, structure: Structure) -> None:
        """Simulate with the numbers that suit the windows best."""
        if structure in self.tried:
            return
        self.tried.add(structure)
        self.start(structure)
        with contextlib.suppress(FlexdynError):
            if structure in self.fits:
                here = self.fits[structure]
                self._take(structure, fit_to_windows(searched(here) if unlike_noise(here.shot) else here))
                self.fitted.add(structure)

    def _take(self, structure: Structure, made: WindowFit) -> None:
        if math.isfinite(made.log_posterior):  # else no window could be simulated
            self.fits[structure], likelihood = made, made.shot.log_likelihood
            rest = self.found.space.log_volume(structure) + made.log_posterior - likelihood
            self._weighed[structure] = (rest, likelihood, _is_noise(made.shot))

    @property
    def known(self) -> dict[Structure, float]:
        """Log posteriors of those simulated.

        Where windows and innovations are noise, all have the greatest likelihood: level and spectrum of the noise are
        not known well enough to compare covariances.
        """
        most = max((likelihood for _, likelihood, _ in self._weighed.values()), default=0.0)
        return {
            structure: rest + (most if noise else likelihood)
            for structure, (rest, likelihood, noise) in self._weighed.items()
        }

    def best(self) -> Structure:
        """The most likely of those simulated."""
        known = self.known
        return max(known, key=lambda s: (known[s], sorted(s)))

    def around(self, here: Structure) -> None:
        """Compare a fitted structure with those that lack one of its candidates, or have another in its place.

        All that lack a candidate are fitted, and the best ones that have another.
        """
        swaps = []
        for each in sorted(here):
            self.fit(here - {each})
            swaps += self._with_one_more(here - {each}, SWAPS, but=each[0])
        for structure in self._first(swaps)[:FITTED_SWAPS]:
            self.fit(structure)

    def grown(self, here: Structure) -> Structure:
        """A fitted structure with what its windows lack, candidate by candidate, as long as that is worthwhile.

        Windows that are at noise lack nothing: more would only change in which ones a joint sticks.
        """
        if len(here) >= LARGEST_QUESTIONED or self.fits[here].explains:
            return here
        for more in self._first(self._with_one_more(here, ADDITIONS))[:1]:
            self.fit(more)
            if self.is_worthwhile(more, here):
                return self.grown(more)
        return here

    def _with_one_more(self, base: Structure, most: int, but: int | None = None) -> list[Structure]:
        """A structure with each of the candidates that the equations, or its windows, like best; simulated.

        No linear response tells of a spring that makes a rigid joint vibrate: such candidates are simulated anyway. Nor
        does one tell of a law without a linear number, such as a gap: all its grid points are simulated between which
        the equations do not choose.
        """
        scan = Scan(self.found.space)
        liked = [point for _, point in scan.additions(base) if point[0] != but]
        promised = {each.point: each for each in self._promising(base) if each.point[0] != but}
        unasked = [point for point in liked if not is_asked(self.found.space, point[0])]
        if base in self.fitted:  # of others its windows say that they would be none
            liked = [point for point in liked if point in promised]
        points = dict.fromkeys([*liked[:most], *list(promised)[:most], *unasked[:most]])
        if base in self.fitted:
            points |= dict.fromkeys(self._beside(base, [each for each in scan.undecided(base) if each[0] != but]))
        for point in points:
            if point in promised:
                self.start_with(base, promised[point])
            else:
                self.start(base | {point})
        return [base | {point} for point in points]

    def _beside(self, base: Structure, points: list[tuple[int, int]]) -> list[tuple[int, int]]:
        """Those of some points that make an effect; simulated with the numbers of a fitted structure."""
        here, found = self.fits[base], []
        still = np.zeros(len(here.made.regression.sigma))
        for point in points:
            effect, structure = self.found.space.candidates[point[0]].effect(point[1], np.zeros(0)), base | {point}
            if effect is None:
                continue
            found.append(point)
            if structure not in self.fits:
                with contextlib.suppress(FlexdynError):
                    self._take(structure, here.with_one_more(effect, None, still))
        return found

    def _promising(self, base: Structure) -> list[Addition]:
        """What the windows of a structure would gain; nothing where its numbers were not fitted to them."""
        if base in self.fitted and base not in self.promised:
            self.promised[base] = promising(self.fits[base], self.found.space, base, self.responses)
        return self.promised.get(base, [])

    def climbed(self, start: Structure) -> Structure:
        """The best structure of a search that begins at one, or at nothing, and goes on to better neighbours.

        The equations may prefer several candidates to one that they hardly see. No neighbour of these leads there. What
        they hardly tell apart is simulated before any numbers are fitted to windows: the search begins at the best of
        it.
        """
        self.start(start)
        if start in self.fits and unlike_noise(self.fits[start].shot):
            self._rivals(start)
            start = self.best()
        for each in (start, frozenset[tuple[int, int]]()):
            self.start(each)
            lacking = each not in self.fits or not self.fits[each].explains
            self.fit(each)
            if lacking and each in self.fitted:
                self.grown(each)
            if not lacking or (self.fits and self.fits[self.best()].explains):
                break
        for _ in range(SEARCH_ROUNDS if self.fits else 0):
            here = self.best()
            self.around(here)
            if not self.is_worthwhile(self.best(), here):
                break
            self.grown(self.best())
        return self.best() if self.fits else start

    def _rivals(self, structure: Structure) -> None:
        """Simulate what loses little in the place of each candidate in the equations, where reversals are masked."""
        scan = Scan(self.found.space)
        for each in sorted(structure):
            rest = structure - {each}
            additions = scan.additions(rest)
            least = (1.0 - STRONG_GAIN_SHARE) * next(
                (gain for gain, point in additions if point[0] == each[0]), math.inf
            )
            near = [point for gain, point in additions if point[0] != each[0] and gain > least]
            for point in near[:RIVALS_SIMULATED]:
                self.start(rest | {point})

    def is_worthwhile(self, there: Structure, here: Structure) -> bool:
        """Whether a search goes on from a structure that came after another one."""
        known = self.known
        return known[there] - known[here] > self.fits[there].worthwhile

    def _first(self, structures: list[Structure]) -> list[Structure]:
        """Those that could be simulated, the most likely one first."""
        known = self.known
        return sorted((s for s in structures if s in known), key=lambda s: (-known[s], sorted(s)))


def _is_noise(shot: Shot) -> bool:
    """Whether neither the windows nor their innovations leave more than noise: each hides what the other one shows.

    In the windows errors drown in the noise that builds up; innovations forgive those that build up slowly.
    """
    return not unlike_noise(shot) and shot.has_white_innovations()
