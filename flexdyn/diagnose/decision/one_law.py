"""Laws that contain one another: which of them is told.

Coulomb friction and a torque offset of one motor are asymmetric friction. Both models are the same, so no data separate
them, and the one law is the plainer answer. Where what a law has beyond a plainer one may be an imitation of something
unknown, the plainer one is told, and the law is its rival.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Collection, Iterable, Iterator, Mapping

from flexdyn.diagnose.constants import ESTABLISHED, EVEN_ODDS_WINDOW
from flexdyn.diagnose.decision.masses import Masses
from flexdyn.diagnose.decision.naming import Name
from flexdyn.diagnose.hypothesis.estimate import fit
from flexdyn.diagnose.inference.odds_by_fits import LAST_STEPS
from flexdyn.diagnose.inference.passes import Posterior
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
    return dataclasses.replace(with_best(found, best), known=known)


def by_plainer_laws(found: Posterior, genuine: Mapping[int, float]) -> Posterior:
    """The posterior whose best structure has the plainer law in the place of one that may be an imitation.

    Sets of both remain compared, so that the name of the plainer law is an "A or B". A law that is several others
    together is replaced by all of them: the model stays the same.

    Args:
        found: the posterior over structures.
        genuine: by candidate, probability that it is no imitation of something unknown [1]; none: it is certain.
    """
    space, best = found.space, found.best
    parts = {whole: some for some, whole in _sums(space)}
    plain = {(each.kind, each.spot): c for c, each in enumerate(space.candidates)}
    for c, p in sorted(best):
        law, spot = space.candidates[c].law, space.candidates[c].spot
        contained = parts.get(c) or {plain[kind, spot] for kind in law.plainer[:1] if (kind, spot) in plain}
        if contained and genuine.get(c, 1.0) < ESTABLISHED:
            best = best - {(c, p)} | {(k, 0) for k in contained}
    return with_best(found, best)


def completing(space: Space, masses: Masses, names: Iterable[Name], there: Collection[int]) -> frozenset[int]:
    """Candidates that make a name the law that is its rival: the offset of "Coulomb or asymmetric friction".

    Which of the two it is called is open, but what the rival has beyond the name is certain. Without that, it would be
    left over, and displace everything else.

    Args:
        space: that compared the candidates.
        masses: of all sets.
        names: established ones.
        there: candidates of the best structure.
    """
    told = {each.candidate: each.rivals for each in names}
    return frozenset(
        c
        for parts, whole in _sums(space)
        if any(whole in told[c] for c in parts & told.keys())
        for c in (parts & frozenset(there)) - told.keys()
        if masses.of_any([c, whole]) >= ESTABLISHED
    )


def with_best(found: Posterior, best: Structure) -> Posterior:
    """The posterior with another best structure, which is fitted."""
    if best == found.best:
        return found
    found.space.value(best)  # it is one of those that are compared
    made = fit(hypothesis_of(found.space, best, whole=True), found.fitted.space, steps=LAST_STEPS)
    return dataclasses.replace(found, best=best, fitted=made)


def _sums(space: Space) -> Iterator[tuple[frozenset[int], int]]:
    """Candidates of one joint, with the one that is all of them together."""
    joints: dict[str | None, list[int]] = {}
    for c, each in enumerate(space.candidates):
        joints.setdefault(each.spot[0], []).append(c)
    for c, whole in enumerate(space.candidates):
        if not whole.law.sum_of:
            continue
        (joint, side), there = whole.spot, {}
        for k in joints[joint]:
            each = space.candidates[k]
            if each.spot == whole.spot or side not in each.law.sides:
                there[each.kind] = k
        if there.keys() >= set(whole.law.sum_of):
            yield frozenset(there[kind] for kind in whole.law.sum_of), c


def _merged(structure: Structure, parts: frozenset[int], whole: int) -> Structure:
    """A structure with the one law, if it has all parts of it."""
    if not parts <= {c for c, _ in structure}:
        return structure
    return frozenset(each for each in structure if each[0] not in parts) | {(whole, 0)}


def _even(space: Space, structure: Structure) -> float:
    """Log posterior at even prior odds of places."""
    return space.value(structure) - space.places.log_prior(structure)
