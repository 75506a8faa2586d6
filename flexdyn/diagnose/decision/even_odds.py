"""Rivals that fit the data as well as a name does, and are less probable by the prior alone.

Friction is expected of every motor, a constant offset of few. Where the data cannot tell them apart, because a joint
moved one way only, the prior alone would make friction a name. So each name is compared with every other law in its
place at even prior odds. The answer is "A or B" if the Bayes factor is below 3 and the motion leaves the two alike.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace

from flexdyn.diagnose.constants import ESTABLISHED, EVEN_ODDS_WINDOW, SMALLEST_TORQUE_SHARE
from flexdyn.diagnose.decision.masses import Masses, Set
from flexdyn.diagnose.decision.naming import Name
from flexdyn.diagnose.inference.scan import nested
from flexdyn.diagnose.inference.space import Space
from flexdyn.diagnose.inference.substitutes import own_share


def told_by_data(
    space: Space, masses: Masses, best: Set, named: Sequence[Name], stands_in: Callable[[int, int], bool]
) -> tuple[Name, ...]:
    """Names with the rivals that are less probable by the prior alone.

    A law that contains the named one, or is contained in it, is no rival: by convention the plainer one is named. Two
    names of which the data need one, but not both, become one name.

    Args:
        space: that compared the candidates.
        masses: of all sets.
        best: the set that is named.
        named: its established candidates.
        stands_in: whether of two candidates the second may be a rival of the first.
    """
    even = {
        mine: float(log) - space.places.log_prior(structure)
        for mine, structure, log in zip(masses.sets, masses.structures, masses.log, strict=True)
    }
    if best not in even:
        return tuple(named)
    found: list[Name] = []
    for name in sorted(named, key=lambda each: even.get(best - {each.candidate}, -float("inf"))):
        if any(name.candidate in other.held_down for other in found):
            continue
        held = [
            c
            for c in _held_down(space, masses, even, best, name)
            if c not in name.rivals and stands_in(name.candidate, c)
        ]
        held += _either_of_two(space, even, best, name, [each.candidate for each in named])
        together = masses.of_any([name.candidate, *name.rivals, *held])
        probability = name.probability * together / masses.of_any([name.candidate, *name.rivals])
        found.append(replace(name, rivals=(*name.rivals, *held), probability=probability, held_down=tuple(held)))
    return tuple(sorted(found, key=lambda each: each.candidate))


def _held_down(space: Space, masses: Masses, even: Mapping[Set, float], best: Set, name: Name) -> list[int]:
    """Candidates that fit as well in the place of a name, though fewer drives have them; the most likely first.

    No more than are needed to be certain of one of them where all are equally expected. Only laws without nonlinear
    numbers count: one that takes the shape that suits imitates too much.
    """
    found: dict[int, float] = {}
    told = [space.candidates[c] for c in (name.candidate, *name.rivals)]
    rest = best - {name.candidate}
    prior = space.places.log_prior(frozenset((c, 0) for c in best))
    for other, value in even.items():
        if len(other) != len(best) or not rest < other or name.candidate in other:
            continue
        (c,) = other - rest
        if space.candidates[c].choices > 1:
            continue
        if own_share(space, masses.structures[masses.sets.index(best)], name.candidate, c) > SMALLEST_TORQUE_SHARE:
            continue  # the motion tells them apart; what the catalogue lacks hides it
        expected_less = space.places.log_prior(frozenset((each, 0) for each in other)) < prior
        if (
            expected_less
            and value > even[best] - EVEN_ODDS_WINDOW
            and not any(nested(each, space.candidates[c]) for each in told)
        ):
            found[c] = math.exp(value - even[best])
    ordered, together = sorted(found, key=lambda c: (-found[c], c)), 1.0 + sum(found.values())
    needed = 0
    while 1.0 + sum(found[c] for c in ordered[:needed]) < ESTABLISHED * together:
        needed += 1
    return ordered[:needed]


def _either_of_two(space: Space, even: Mapping[Set, float], best: Set, name: Name, others: Sequence[int]) -> list[int]:
    """Other names of the set: the data need this name or the other one, but not both."""
    nothing = -float("inf")
    bound, without = even[best] - EVEN_ODDS_WINDOW, even.get(best - {name.candidate}, nothing)
    found = []
    for c in others:
        apart = even.get(best - {c}, nothing)
        neither = even.get(best - {c, name.candidate}, nothing)
        one_of_them = min(without, apart) > bound and neither < min(without, apart) - EVEN_ODDS_WINDOW
        if c != name.candidate and one_of_them and not nested(space.candidates[name.candidate], space.candidates[c]):
            found.append(c)
    return found
