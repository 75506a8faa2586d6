"""Names: candidates whose probability, or that of "A or B" together, is high enough."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass
from functools import partial

from flexdyn.diagnose.constants import ESTABLISHED, RIVAL_PROBABILITY
from flexdyn.diagnose.decision.masses import Masses, Set


@dataclass(frozen=True)
class Name:
    """A candidate of the best set and the candidates that replace it in other sets.

    Attributes:
        candidate: its place.
        rivals: places of those that other sets hold in its place, the most probable first.
        probability: that it or one of the rivals is there [1].
        held_down: those of the rivals that the data like as well, and only the prior does not.
    """

    candidate: int
    rivals: tuple[int, ...]
    probability: float
    held_down: tuple[int, ...] = ()

    @property
    def established(self) -> bool:
        """Whether this is probable enough to be reported."""
        return self.probability >= ESTABLISHED


def names(
    masses: Masses,
    best: Set,
    genuine: Mapping[int, float] | None = None,
    of: Collection[int] | None = None,
    stands_in: Callable[[int, int], bool] = lambda _, __: True,
) -> list[Name]:
    """What the candidates of the best set are called, in the order of their places.

    Args:
        masses: of all sets.
        best: the set.
        genuine: by candidate, probability that it is no imitation of something unknown; None: that is certain.
        of: candidates of the set to be named; None: all.
        stands_in: whether of two candidates the second may be a rival of the first.
    """
    own = genuine or {}
    return [_named(masses, best, c, own.get(c, 1.0), stands_in) for c in sorted(best if of is None else of)]


def _named(masses: Masses, best: Set, candidate: int, genuine: float, stands_in: Callable[[int, int], bool]) -> Name:
    """One candidate, with rivals until together they are established, or there are none left."""
    rivals: list[int] = []
    together = masses.of_any([candidate])
    while together * genuine < ESTABLISHED:
        more = standing_in(masses, best, {candidate, *rivals}, partial(stands_in, candidate))
        if not more:
            break
        # The one that is mostly there where the others are not, and not one that is there anyway.
        rivals.append(min(more, key=lambda c: (-(more[c] ** 2) / masses.of_any([c]), c)))
        together = masses.of_any([candidate, *rivals])
    return Name(candidate, tuple(rivals), together * genuine)


def standing_in(
    masses: Masses, best: Set, named: set[int], stands_in: Callable[[int], bool] = lambda _: True
) -> dict[int, float]:
    """Probability of every further rival in the sets that hold nothing that is named yet."""
    found: dict[int, float] = {}
    for mine, probability in zip(masses.sets, masses.probability.tolist(), strict=True):
        if mine.isdisjoint(named):
            for c in mine - best:
                found[c] = found.get(c, 0.0) + probability
    return {c: mass for c, mass in found.items() if mass >= RIVAL_PROBABILITY and stands_in(c)}
