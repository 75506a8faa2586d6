"""Structures that other linearisations prefer, weighed by fits: a fit is exact where a linearisation only promises."""

from __future__ import annotations

import math
from collections.abc import Iterable

import numpy as np

from flexdyn.arrays import Array, Flags
from flexdyn.diagnose.constants import CERTAIN_SIGMAS, NOISE_LEVEL_ERROR, OCCAM_WINDOW, STRONG_GAIN_SHARE
from flexdyn.diagnose.equations.equations import Equations
from flexdyn.diagnose.hypothesis.chord import chord_fit
from flexdyn.diagnose.hypothesis.estimate import fit
from flexdyn.diagnose.hypothesis.fitted import Fit
from flexdyn.diagnose.hypothesis.hypothesis import Hypothesis
from flexdyn.diagnose.hypothesis.linear import priors
from flexdyn.diagnose.hypothesis.workspace import Workspace
from flexdyn.diagnose.inference.search import Scan
from flexdyn.diagnose.inference.space import Space, Structure
from flexdyn.diagnose.inference.structure_model import hypothesis_of, waits
from flexdyn.diagnose.inference.whitening import Tempered
from flexdyn.errors import SimulationError

STEPS_OF_A_FIT, STEPS_TRIED = 8, 2
"""Gauss-Newton steps of the fit of a structure that another linearisation prefers, and of one that is tried."""


def odds_by_fits(space: Space, best: Structure, fitted: Fit, others: Iterable[frozenset[int]]) -> tuple[float, ...]:
    """Odds of structures to the best one, at most 1: all of them fitted under the best one's weights.

    ``log p = log likelihood of what the fit leaves + log priors at its numbers + Occam's factor``; the last one is that
    of the linear equations.

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
    nothing for the right law. So where more than noise is left, candidates are tried by fits.

    Args:
        space: of the linearisation.
        best: its best structure.
        base: the fit of `stands`, under whose weights all are fitted.
        stands: the structure at which it is.
    """
    lacks = _lacks(space, base)
    added = [point for gain, point in Scan(space).additions(stands) if lacks and gain > -OCCAM_WINDOW]
    values = {stands: log_posterior(space, stands, base)}
    for each in (best, *_with(space, stands, added)):
        if each not in values:
            values[each] = _by_fit(space, each, base, STEPS_TRIED)
    return max(values, key=lambda each: values[each])


def best_where_not_linear(space: Space, best: Structure, base: Fit, stands: Structure) -> Structure:
    """The best structure of a linearisation, or one candidate that explains everything alone by a fit.

    The linear equations may be far from right for small errors of the file's numbers where a position is not measured.
    So if the fit of the best structure does not keep what they promise, the candidates that promise most alone are
    fitted. One that leaves noise alone, and is more likely, is taken.

    Args:
        space: of the linearisation.
        best: its best structure, another one than `stands`.
        base: the fit of `stands`, under whose weights all are fitted.
        stands: the structure at which it is.
    """
    kept = _by_fit(space, best, base, STEPS_OF_A_FIT)
    if kept > space.value(best) - OCCAM_WINDOW:
        return best
    gains = Scan(space).additions(stands)
    strong = [point for gain, point in gains if gain > STRONG_GAIN_SHARE * gains[0][0]]
    for structure in _with(space, stands, strong):
        made = _fit_of_structure(space, structure, base, STEPS_OF_A_FIT)
        if made is None or _lacks(space, made):
            continue
        value = log_posterior(space, structure, made)
        if value > kept:
            best, kept = structure, value
    return best


def fit_if_likely(
    space: Space, structure: Structure, start: Hypothesis, base: Fit, least: float
) -> tuple[float, Fit | None]:
    """Log posterior of a structure by its fit, and the fit, which ends early where it will not reach a least value.

    The first steps keep the slopes of another fit. What they reach, and what they promise beyond it, tells whether the
    fit goes on with its own slopes.

    Args:
        space: of the linearisation.
        structure: to be fitted.
        start: its first values.
        base: a fit near it, under whose weights this one is made.
        least: log posterior that it must reach to be of interest.
    """
    try:
        made = chord_fit(start, base)
    except SimulationError:  # nothing can be computed there
        return -math.inf, None

    def hopeless(made: Fit) -> bool:
        return log_posterior(space, structure, made) + 0.5 * (made.reached - made.chi2) <= least

    if not hopeless(made):
        made = fit(made.hypothesis, base.space, steps=STEPS_OF_A_FIT, hopeless=hopeless)
    return log_posterior(space, structure, made), made


def carried_on(space: Space, structure: Structure, made: Fit) -> Fit:
    """A fit that went on in the way in which others are tried beside it, where that makes it more likely."""
    value, other = fit_if_likely(space, structure, made.hypothesis, made, log_posterior(space, structure, made))
    return made if other is None or value <= log_posterior(space, structure, made) else other


def _lacks(space: Space, made: Fit) -> bool:
    """Whether a fit leaves more than noise, chance and a misjudged level of the noise make."""
    count, squares = space.noise.count, squares_left(made.equations, made.space)[0]
    return bool((squares > (1.0 + NOISE_LEVEL_ERROR) * count + CERTAIN_SIGMAS * np.sqrt(2.0 * count)).any())


def _with(space: Space, stands: Structure, added: Iterable[tuple[int, int]]) -> list[Structure]:
    """A structure with each of some candidates in addition."""
    return [stands | {(c, p)} for c, p in added if not waits(space, c)]


def _by_fit(space: Space, structure: Structure, base: Fit, steps: int) -> float:
    """Log posterior of a structure, fitted in some steps."""
    made = _fit_of_structure(space, structure, base, steps)
    return -math.inf if made is None else log_posterior(space, structure, made)


def _fit_of_structure(space: Space, structure: Structure, base: Fit, steps: int) -> Fit | None:
    """The fit of a structure; None: its numbers by the linear equations are no model."""
    try:
        return fit(hypothesis_of(space, structure, whole=True), base.space, steps=steps)
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


def log_posterior(space: Space, structure: Structure, made: Fit) -> float:
    """Of a structure by its fit, not normalised: see `odds_by_fits`."""
    own = space.estimate(structure)
    gained = space.log_gained(made.hypothesis.effects)
    density = _log_density(space, made.hypothesis, made.equations, made.space)
    return density + gained + space.log_volume(structure, own) + space.log_large(structure, own)


def log_density_at(space: Space, there: Hypothesis, work: Workspace) -> float:
    """Of a hypothesis as it is, with the weights of a workspace; -inf where its equations are not finite."""
    try:
        return _log_density(space, there, work.equations.of(there.model()), work)
    except SimulationError:
        return -math.inf


def _log_density(space: Space, there: Hypothesis, at: Equations, work: Workspace) -> float:
    """Log likelihood of what a hypothesis leaves, under the model error of a linearisation, and of the priors.

    These are of the numbers and of the offsets of the encoders: an offset may take up a torque that is missing.
    """
    centre, sigma = priors(there, work)
    squares, of_offsets = squares_left(at, work)
    return space.noise.log_likelihood(squares) - 0.5 * (float(np.sum((centre / sigma) ** 2)) + of_offsets)


def squares_left(at: Equations, work: Workspace, hidden: Flags | bool = False) -> tuple[Array, float]:
    """Sums of the squared rows of each equation that are not hidden, in units of the sensors' noise (equations,).

    And that of the encoders' offsets, over their variances.
    """
    weights = work.at(at)
    white, of_offsets = weights.without_offsets(at.residual)
    squares = (np.where(hidden, 0.0, white).reshape(-1, len(at.kinds)) ** 2).sum(axis=0)
    if isinstance(weights.whiten, Tempered):
        squares = squares * weights.whiten.error.scale**2 * weights.whiten.error.times
    return np.asarray(squares), of_offsets
