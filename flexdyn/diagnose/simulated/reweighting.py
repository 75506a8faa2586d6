"""Structures compared by simulated windows, if the equations cannot separate them."""

from __future__ import annotations

import contextlib
import dataclasses
import itertools
import math
from collections.abc import Callable

from flexdyn.diagnose.constants import CERTAIN_SIGMAS, ERRORS_PER_WINDOW, NOISE_LEVEL_ERROR, STRONG_GAIN_SHARE
from flexdyn.diagnose.hypothesis.estimate import fit
from flexdyn.diagnose.hypothesis.fitted import Fit
from flexdyn.diagnose.inference.passes import Posterior
from flexdyn.diagnose.inference.search import Scan
from flexdyn.diagnose.inference.space import Structure
from flexdyn.diagnose.inference.structure_model import hypothesis_of
from flexdyn.diagnose.shooting.gap import Shot, shoot
from flexdyn.diagnose.shooting.windows import Windows
from flexdyn.diagnose.simulated.window_fit import WindowFit, fit_to_windows
from flexdyn.diagnose.simulated.window_scan import Addition, Responses, is_asked, promising
from flexdyn.effects import JointEffect
from flexdyn.errors import FlexdynError

SWAPS, ADDITIONS = 2, 2
"""Candidates that are tried in the place of each one, and beside all: so many by the equations and by windows each."""
LARGEST_QUESTIONED = 4
"""Candidates of a structure, at most, whose neighbours are simulated: larger ones imitate what the catalogue lacks."""
SEARCH_ROUNDS = 3
"""Structures whose neighbours are compared, at most."""
RIVALS_SIMULATED = 8
"""Candidates that are simulated in the place of each one of the structure that the equations prefer, at most."""
FITTED_SWAPS = 2
"""Swaps whose numbers are fitted to the windows: those that are nearest before."""
COMPARED_WINDOWS = 16
"""Windows over which structures are compared, spread evenly: 8 s; what is found is held against all of them."""
EQUATIONS_FIT_STEPS = 6
"""Steps of the fit to the equations, with a warm start at the linear estimate."""


def unlike_noise(shot: Shot, floor: float = 1.0) -> bool:
    """Whether windows leave together more than noise, chance and a misjudged level of the noise.

    Args:
        shot: the windows; where only some are off, their median says nothing of it.
        floor: the gap of a perfect model, if it is more than 1.
    """
    chance = CERTAIN_SIGMAS * math.sqrt(2.0 / (ERRORS_PER_WINDOW * len(shot.x0)))
    return shot.left > (1.0 + NOISE_LEVEL_ERROR + chance) * max(floor, 1.0) ** 2


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
        self.known: dict[Structure, float] = {}
        self.fits: dict[Structure, WindowFit] = {}
        self.tried: set[Structure] = set()
        self.fitted: set[Structure] = set()
        self.promised: dict[Structure, list[Addition]] = {}
        self.responses: Responses = {}

    def start(self, structure: Structure) -> None:
        """Simulate with the numbers of the equations; a structure that cannot be simulated is left out."""
        if structure in self.fits:
            return
        found = self.found
        with contextlib.suppress(FlexdynError):
            here = hypothesis_of(found.space, structure, whole=True)
            whole = structure == found.best
            made = found.fitted if whole else fit(here, found.fitted.space, steps=EQUATIONS_FIT_STEPS)
            self._take(structure, WindowFit.of(made, self.windows))

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
                self._take(structure, fit_to_windows(self.fits[structure]))
                self.fitted.add(structure)

    def _take(self, structure: Structure, made: WindowFit) -> None:
        if math.isfinite(made.log_posterior):  # else no window could be simulated
            self.fits[structure] = made
            self.known[structure] = made.log_posterior + self.found.space.log_volume(structure)

    def best(self) -> Structure:
        """The most likely of those simulated."""
        return max(self.known, key=lambda s: (self.known[s], sorted(s)))

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
        """A fitted structure with what its windows lack, candidate by candidate, as long as that is worthwhile."""
        if len(here) >= LARGEST_QUESTIONED:
            return here
        for more in self._first(self._with_one_more(here, ADDITIONS))[:1]:
            self.fit(more)
            if self._is_worthwhile(more, here):
                return self.grown(more)
        return here

    def _with_one_more(self, base: Structure, most: int, but: int | None = None) -> list[Structure]:
        """A structure with each of the candidates that the equations, or its windows, like best; simulated."""
        liked = [point for _, point in Scan(self.found.space).additions(base) if point[0] != but]
        promised = {each.point: each for each in self._promising(base) if each.point[0] != but}
        if base in self.fitted:  # of others its windows say that they would be none
            liked = [point for point in liked if point in promised or not is_asked(self.found.space, point[0])]
        points = dict.fromkeys([*liked[:most], *list(promised)[:most]])
        for point in points:
            if point in promised:
                self.start_with(base, promised[point])
            else:
                self.start(base | {point})
        return [base | {point} for point in points]

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
            lacking = each not in self.fits or unlike_noise(self.fits[each].shot)
            self.fit(each)
            if lacking and each in self.fitted:
                self.grown(each)
            if not lacking or (self.known and not unlike_noise(self.fits[self.best()].shot)):
                break
        for _ in range(SEARCH_ROUNDS if self.known else 0):
            here = self.best()
            self.around(here)
            if not self._is_worthwhile(self.best(), here):
                break
            self.grown(self.best())
        return self.best() if self.known else start

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

    def _is_worthwhile(self, there: Structure, here: Structure) -> bool:
        """Whether a search goes on from a structure that came after another one."""
        return self.known[there] - self.known[here] > self.fits[there].worthwhile

    def _first(self, structures: list[Structure]) -> list[Structure]:
        """Those that could be simulated, the most likely one first."""
        return sorted((s for s in structures if s in self.known), key=lambda s: (-self.known[s], sorted(s)))


def share_in_windows(simulated: Simulated, candidate: int) -> float:
    """What a candidate of the best structure takes off the windows, over what is left of them [1].

    With the squared gaps of all windows but the farthest ones: ``(without it - with it) / (with it - 1)``; without it,
    the file's numbers stay within three tolerances. Of the noise's power `NOISE_LEVEL_ERROR` is unknown.

    Args:
        simulated: structures over the windows of the data of the fit.
        candidate: of the best structure.
    """
    found, windows = simulated.found, simulated.windows
    rest = frozenset(each for each in found.best if each[0] != candidate)
    simulated.start(found.best)
    simulated.start(rest)
    if found.best not in simulated.fits or rest not in simulated.fits:
        return 0.0
    whole = simulated.fits[found.best].shot.left
    without = shoot(simulated.fits[rest].made.hypothesis.tolerated().seen(), windows).left
    return max(without - whole, 0.0) / (max(whole - 1.0, 0.0) + NOISE_LEVEL_ERROR)


def _with_other_numbers(simulated: Simulated, here: WindowFit) -> WindowFit:
    """The best structure with numbers that suit all windows, where those that suit some of them come to noise there."""
    best = simulated.found.best
    simulated.fit(best)
    if best not in simulated.fitted or unlike_noise(simulated.fits[best].shot):
        return here
    return fit_to_windows(WindowFit.of(simulated.fits[best].made, here.shot.windows))


def _is_certain(simulated: Simulated, best: Structure) -> bool:
    """Whether windows are certain of what a law of a structure has beyond a plainer one that the equations have there.

    Without it the two are the same, but for when a joint sticks, which noise decides: the more flexible law then fits
    better, whatever the robot has.
    """
    candidates, made = simulated.found.space.candidates, simulated.fits[best].made
    for law, plain in itertools.product(*([candidates[c] for c, _ in each] for each in (best, simulated.found.best))):
        if plain.kind not in law.law.contains or plain.spot != law.spot:
            continue
        common = {each.name for each in plain.law.parameters()}
        unsure = [
            not abs(getattr(effect, name)) > CERTAIN_SIGMAS * sigma
            for (effect, name), sigma in made.std().items()
            if isinstance(effect, JointEffect)
            and (effect.name, effect.joint, effect.side) == (law.kind, *law.spot)
            and name not in common
        ]
        if unsure and all(unsure):
            return False
    return True


def reweighed(
    found: Posterior, windows: Windows, fits: Callable[[Fit], bool], *, all_named: bool = True
) -> Posterior | None:
    """The posterior with the numbers, and if needed the structures, that fit simulated windows.

    Where numbers of the best structure bring its windows to noise, and the equations too, structures stay as the
    equations have them, if all of the best one has names: a part without a name may be what the windows lack. Else its
    neighbours are simulated, and theirs. What comes to noise in the end takes its place, and the structures that were
    simulated are weighed by their windows. Where only a few windows are off, all of them must come to noise together.

    A structure of more than `LARGEST_QUESTIONED` candidates is not searched.

    Args:
        found: by the equations.
        windows: of the data of the fit.
        fits: whether a fit's equations leave noise alone.
        all_named: whether the best structure holds nothing without a name.

    Returns:
        None where nothing brings the windows to noise.
    """
    here = WindowFit.of(found.fitted, windows)
    few = here.shot.is_noise()  # what is missing shows in a few windows alone, as wrong sticking does
    simulated = Simulated(found, windows.thinned(COMPARED_WINDOWS))
    if unlike_noise(here.shot):
        here = _with_other_numbers(simulated, here)
    large = len(found.best) > LARGEST_QUESTIONED
    if (all_named or large) and not unlike_noise(here.shot) and fits(here.made):
        return dataclasses.replace(found, fitted=here.made)
    if large:
        return None
    best = simulated.climbed(found.best)
    if best not in simulated.fits or not _is_certain(simulated, best):
        return None
    if best != found.best:
        here = fit_to_windows(WindowFit.of(simulated.fits[best].made, windows))
    if not here.shot.is_noise() or (few and unlike_noise(here.shot)):
        return None
    # The windows have decided between what the linearisations did not agree about.
    return dataclasses.replace(found, best=best, fitted=here.made, known=simulated.known, earlier=(), by_fits=())
