"""Two named laws that are one: Coulomb friction and a torque offset of one motor are asymmetric friction.

Both models are the same, so no data separate them. The one law is the plainer answer.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Collection, Iterator

from flexdyn.diagnose.hypothesis.estimate import fit
from flexdyn.diagnose.inference.passes import LAST_STEPS, Posterior
from flexdyn.diagnose.inference.rivals import EVEN_ODDS_WINDOW
from flexdyn.diagnose.inference.space import Space, Structure
from flexdyn.diagnose.inference.structure_model import hypothesis_of


def in_one_law(found: Posterior, named: Collection[int]) -> Posterior:
    """The posterior with one law in the place of every two that are together the same.

    Only where both have names, or the best structure has the one law already: what is left unexplained may look like a
    torque offset, and must not take the name of the friction beside it.

    Args:
        found: the posterior over structures.
        named: candidates that have names.
    """
    space, best = found.space, found.best
    joined = []
    for parts, whole in _sums(space):
        merged = _merged(best, parts, whole) if parts <= set(named) else best
        if merged != best and _even(space, merged) < _even(space, best) - EVEN_ODDS_WINDOW:
            continue
        if whole in {c for c, _ in merged}:
            best = merged
            joined.append((parts, whole))
    if not joined:
        return found
    known: dict[Structure, float] = {}
    for structure, value in found.known.items():
        for parts, whole in joined:
            structure = _merged(structure, parts, whole)
        known[structure] = max(value, known.get(structure, value))
    made = found.fitted
    if best != found.best:
        made = fit(hypothesis_of(space, best, whole=True), made.space, steps=LAST_STEPS)
    return dataclasses.replace(found, best=best, fitted=made, known=known)


def _sums(space: Space) -> Iterator[tuple[frozenset[int], int]]:
    """Candidates of one joint, with the one that is all of them together."""
    for c, whole in enumerate(space.candidates):
        (joint, side), there = whole.spot, {}
        for k, each in enumerate(space.candidates):
            if each.spot == whole.spot or (each.spot[0] == joint and side not in each.law.sides):
                there[each.kind] = k
        if whole.law.sum_of and there.keys() >= set(whole.law.sum_of):
            yield frozenset(there[kind] for kind in whole.law.sum_of), c


def _merged(structure: Structure, parts: frozenset[int], whole: int) -> Structure:
    """A structure with the one law, if it has all parts of it."""
    if not parts <= {c for c, _ in structure}:
        return structure
    return frozenset(each for each in structure if each[0] not in parts) | {(whole, 0)}


def _even(space: Space, structure: Structure) -> float:
    """Log posterior at even prior odds of places."""
    return space.value(structure) - space.log_places(structure)
