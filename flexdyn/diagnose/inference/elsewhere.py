"""Structures that other linearisations prefer, weighed by fits: a fit is exact where a linearisation only promises."""

from __future__ import annotations

import math
from collections.abc import Iterable

import numpy as np

from flexdyn.diagnose.hypothesis.estimate import fit
from flexdyn.diagnose.hypothesis.fitted import Fit
from flexdyn.diagnose.hypothesis.linear import priors
from flexdyn.diagnose.inference.space import Space, Structure
from flexdyn.diagnose.inference.structure_model import hypothesis_of
from flexdyn.diagnose.inference.whitening import Tempered
from flexdyn.errors import SimulationError

STEPS_ELSEWHERE = 8
"""Gauss-Newton steps of the fit of a structure that another linearisation prefers."""


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
    here = _log_posterior(space, best, fitted)
    found = []
    for each in others:
        structure = _in_space(space, each)
        start = hypothesis_of(space, structure, whole=True)
        try:
            made = fit(start, fitted.space, steps=STEPS_ELSEWHERE)
        except SimulationError:  # its numbers by the linear equations are no model: the fits cannot decide
            found.append(1.0)
            continue
        found.append(math.exp(min(0.0, _log_posterior(space, structure, made) - here)))
    return tuple(found)


def _in_space(space: Space, candidates: frozenset[int]) -> Structure:
    """Candidates with the grid points at which they were the most likely."""
    ranked = sorted(space.known, key=lambda s: (-space.known[s], sorted(s)))
    place: dict[int, int] = {}
    for structure in ranked:
        for c, p in structure:
            place.setdefault(c, p)
    same = next((s for s in ranked if {c for c, _ in s} == candidates), None)
    return same if same is not None else frozenset((c, place.get(c, 0)) for c in candidates)


def _log_posterior(space: Space, structure: Structure, made: Fit) -> float:
    """Of a fitted structure, not normalised."""
    weights, many = made.space.at(made.equations), len(made.equations.kinds)
    whiten = weights.whiten
    squares = (weights.white(made.equations.residual).reshape(-1, many) ** 2).sum(axis=0)
    if isinstance(whiten, Tempered):
        squares = squares * whiten.error.scale**2 * whiten.error.times
    centre, sigma = priors(made.hypothesis, made.space)
    own = space.gram.estimate(space.columns(structure))
    volume = space.log_volume(structure, own) + space.log_large(structure, own)
    return space.noise.log_likelihood(squares) - 0.5 * float(np.sum((centre / sigma) ** 2)) + volume
