"""Rivals with refined parameters: the grid is coarser than the refined parameters of the best structure."""

from __future__ import annotations

import itertools

from flexdyn.diagnose.constants import EVEN_ODDS_WINDOW
from flexdyn.diagnose.hypothesis.proposal import Point
from flexdyn.diagnose.inference.candidate import Candidate
from flexdyn.diagnose.inference.refinement import refined
from flexdyn.diagnose.inference.scan import Scan
from flexdyn.diagnose.inference.search import explore
from flexdyn.diagnose.inference.space import Space, Structure


def among_rivals(space: Space, best: Structure) -> Structure:
    """Compare the best structure with rivals of each of its effects, their nonlinear parameters refined.

    The same law at other places has a warm start: the numbers of the effect.

    Returns:
        The most likely structure.
    """
    for c, p in sorted(best):
        _grow_alike(space, space.candidates[c], _nonlinear_numbers(space.candidates[c], p))
    scan = Scan(space)
    for each in sorted(best):
        rest = best - {each}
        points = (point for _, point in scan.additions(rest) if point[0] != each[0])
        rival = next((point for point in points if space.candidates[point[0]].choices > 1), None)
        if rival is not None:
            refined(space, rest | {rival})
    best = best if space.best() == best else explore(space, [space.best()])
    _evenly(space, best)
    return best


def _evenly(space: Space, best: Structure) -> None:
    """Compare what the prior of places alone may hold down: other laws in the place of each, and less of them."""
    scan, bound = Scan(space), space.value(best) - space.places.log_prior(best) - EVEN_ODDS_WINDOW

    def stands(structure: Structure, value: float) -> bool:
        """Whether a structure is likely but for the prior of places."""
        return value - space.places.log_prior(structure) > bound

    for each in sorted(best):
        rest = best - {each}
        value = space.value(rest)
        for gain, point in scan.additions(rest):
            if space.candidates[point[0]].choices == 1 and stands(rest | {point}, value + gain):
                space.value(rest | {point})
    spare = [each for each in sorted(best) if stands(best - {each}, space.value(best - {each}))]
    for pair in itertools.combinations(spare, 2):
        space.value(best - frozenset(pair))


def _nonlinear_numbers(candidate: Candidate, p: int) -> Point:
    """Nonlinear parameters of a candidate, wherever they come from."""
    if candidate.stands is None or candidate.proposal is None:
        return candidate.points[p]
    return tuple(float(getattr(candidate.stands, axis)) for axis in candidate.proposal.axes)


def _grow_alike(space: Space, mine: Candidate, point: Point) -> None:
    """Give the same law at other places, and other waves over the same joint's turn, a grid point.

    Of a wave that stands, no residual's spectrum has a peak: another one at its harmonic is on no grid.
    """
    for c, other in enumerate(space.candidates):
        if point and other is not mine and other.stands is None and _has_same_numbers(mine, other):
            space.grow(c, point)


def _has_same_numbers(one: Candidate, other: Candidate) -> bool:
    """Whether nonlinear parameters of one candidate may be those of another one."""
    if other.kind == one.kind:
        return True
    mine, its = one.proposal, other.proposal
    waves = one.law.cycles and other.law.cycles
    return bool(waves and mine and its and mine.joint == its.joint and mine.axes == its.axes)
