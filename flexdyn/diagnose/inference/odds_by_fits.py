"""Structures that other linearisations prefer, weighed by fits: a fit is exact where a linearisation only promises."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterable
from typing import TypeVar

from flexdyn.diagnose.constants import OCCAM_WINDOW, STRONG_GAIN_SHARE
from flexdyn.diagnose.hypothesis.estimate import fit
from flexdyn.diagnose.hypothesis.fitted import Fit
from flexdyn.diagnose.hypothesis.hypothesis import Hypothesis
from flexdyn.diagnose.inference.posterior_of_fit import (
    STEPS_OF_A_FIT,
    fit_if_likely,
    leaves_more_than_noise,
    log_posterior,
    noise_would_gain,
)
from flexdyn.diagnose.inference.scan import Scan
from flexdyn.diagnose.inference.space import Identities, Space, Structure
from flexdyn.diagnose.inference.structure_model import hypothesis_of, waits
from flexdyn.errors import SimulationError

LAST_STEPS, MOST_TRIED = 8, 12
"""Gauss-Newton steps at most of the last fit; candidates that are tried by fits in a pass, at most."""
Tried = TypeVar("Tried", bound=Fit | None)


def odds_by_fits(space: Space, best: Structure, fitted: Fit, others: Iterable[frozenset[int]]) -> tuple[float, ...]:
    """Odds of structures to the best one, at most 1: all of them fitted under the best one's weights.

    Args:
        space: of the last linearisation.
        best: its best structure.
        fitted: the fit of that one.
        others: candidates of each of the others.
    """
    here = log_posterior(space, best, fitted)
    found = []
    for each in others:
        structure = in_space(space, each)
        made = _fit_of_structure(space, structure, fitted, STEPS_OF_A_FIT)  # None: the fits cannot decide
        value = here if made is None else log_posterior(space, structure, made)
        found.append(math.exp(min(0.0, value - here)))
    return tuple(found)


def best_by_fits(space: Space, best: Structure, base: Fit, stands: Structure) -> Structure:
    """The most likely by fits of what a linearisation stands at, what it prefers, and each candidate in addition.

    Simulated links may vibrate. The equations are then far from linear in the numbers, and their slopes may promise
    nothing for the right law. So where more than noise is left, candidates are tried by fits, until noise alone
    would hardly be more likely than what one leaves: what may take its place is a matter of the equations near it.

    Args:
        space: of the linearisation.
        best: its best structure.
        base: the fit of `stands`, under whose weights all are fitted.
        stands: the structure at which it is.
    """
    leaves = leaves_more_than_noise(base)
    gains = Scan(space).additions(stands) if leaves else []
    added = [point for gain, point in gains if gain > -OCCAM_WINDOW][:MOST_TRIED]
    others = dict.fromkeys(each for each in (best, *_with(space, stands, added)) if each != stands)
    likeliest, most = stands, log_posterior(space, stands, base)
    for each in others:
        value, made = fit_if_likely(space, each, hypothesis_of(space, each, whole=True), base, most)
        if made is not None and value > most:
            likeliest, most = each, value
            if noise_would_gain(space, made) < OCCAM_WINDOW:
                break
    return likeliest


def best_where_not_linear(space: Space, best: Structure, base: Fit, stands: Structure) -> Structure:
    """The best structure of a linearisation, or one candidate that explains everything alone by a fit.

    The linear equations may be far from right for small changes of the file's numbers: where a position is not
    measured, or where encoders are so noisy that the rows' covariance follows the numbers. So if the fit of the best
    structure does not keep what they promise, the candidates that promise most alone are fitted. One that leaves noise
    alone, and is more likely, is taken.

    Args:
        space: of the linearisation.
        best: its best structure, another one than `stands`.
        base: the fit of `stands`, under whose weights all are fitted.
        stands: the structure at which it is.
    """
    kept = best, _fit_of_structure(space, best, base, STEPS_OF_A_FIT)
    if _value(space, *kept) > space.value(best) - OCCAM_WINDOW:
        return best
    gains = Scan(space).additions(stands)
    strong = [point for gain, point in gains if gain > STRONG_GAIN_SHARE * gains[0][0]]
    tried = ((each, _fit_of_structure(space, each, base, STEPS_OF_A_FIT)) for each in _with(space, stands, strong))
    alone = ((each, made) for each, made in tried if made is not None and not leaves_more_than_noise(made))
    return _most_likely(space, itertools.chain([kept], alone))[0]


def most_likely_visited(
    space: Space, best: Structure, fitted: Fit, visited: Iterable[tuple[Identities, Hypothesis]]
) -> tuple[Structure, Fit]:
    """The most likely by fits of the last structure and those of earlier passes: a search that does not settle wanders.

    Args:
        space: of the last linearisation.
        best: its best structure.
        fitted: the fit of that one, under whose weights all are fitted.
        visited: structures of earlier passes, and where their fits ended.
    """
    tried = [(best, fitted)]
    for identities, there in visited:
        candidates = space.having(identities)
        if len(candidates) == len(identities) and (made := _fit_from(there, fitted, LAST_STEPS)) is not None:
            tried.append((in_space(space, candidates), made))
    best, fitted = _most_likely(space, tried)
    space.value(best)  # it is one of those that are compared
    return best, fitted


def _with(space: Space, stands: Structure, added: Iterable[tuple[int, int]]) -> list[Structure]:
    """A structure with each of some candidates in addition."""
    return [stands | {(c, p)} for c, p in added if not waits(space, c)]


def _most_likely(space: Space, fits: Iterable[tuple[Structure, Tried]]) -> tuple[Structure, Tried]:
    """The structure that is the most likely by its fit, and the fit; the first of equals."""
    return max(fits, key=lambda each: _value(space, *each))


def _value(space: Space, structure: Structure, made: Fit | None) -> float:
    """Log posterior of a structure by its fit, if it has one."""
    return -math.inf if made is None else log_posterior(space, structure, made)


def _fit_of_structure(space: Space, structure: Structure, base: Fit, steps: int) -> Fit | None:
    """The fit of a structure; None: its numbers by the linear equations are no model."""
    return _fit_from(hypothesis_of(space, structure, whole=True), base, steps)


def _fit_from(start: Hypothesis, base: Fit, steps: int) -> Fit | None:
    """A fit under the weights of another one; None: it begins where nothing can be computed."""
    try:
        return fit(start, base.space, steps=steps)
    except SimulationError:
        return None


def in_space(space: Space, candidates: frozenset[int]) -> Structure:
    """Candidates with the grid points at which they were the most likely."""
    ranked = sorted(space.known, key=lambda s: (-space.known[s], sorted(s)))
    place: dict[int, int] = {}
    for structure in ranked:
        for c, p in structure:
            place.setdefault(c, p)
    same = next((s for s in ranked if {c for c, _ in s} == candidates), None)
    return same if same is not None else frozenset((c, place.get(c, 0)) for c in candidates)
