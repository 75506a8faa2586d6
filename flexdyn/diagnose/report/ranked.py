"""Ranked structures: those that hold some effects, against those that hold none of them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from flexdyn.diagnose.report.suspects import Structure, Suspect


@dataclass(frozen=True)
class Ranks:
    """The structures that hold one of some effects, and those that hold none of them.

    Attributes:
        among: number of structures that were ranked.
        holding: places of those that hold it, counted from 1.
        probability: that these have together [1].
        best: the one of the highest evidence with it; None where there is none.
        other: the one of the highest evidence without it; None where there is none.
    """

    among: int
    holding: tuple[int, ...]
    probability: float
    best: Structure | None
    other: Structure | None

    @property
    def log_bayes_factor(self) -> float | None:
        """Of the best structure with it against the best without it; None where one of them is missing."""
        if self.best is None or self.other is None:
            return None
        return self.best.log_evidence - self.other.log_evidence


def ranks(structures: Sequence[Structure], suspects: Sequence[Suspect]) -> Ranks:
    """The structures that hold any of the effects of a finding."""
    keys = {each.key for each in suspects}
    held = [bool(keys & {each.key for each in structure.effects}) for structure in structures]
    within = [structure for structure, it_is in zip(structures, held, strict=True) if it_is]
    without = [structure for structure, it_is in zip(structures, held, strict=True) if not it_is]
    return Ranks(
        len(structures),
        tuple(place for place, it_is in enumerate(held, start=1) if it_is),
        sum(each.probability for each in within),
        max(within, key=lambda each: each.log_evidence, default=None),
        max(without, key=lambda each: each.log_evidence, default=None),
    )


def beyond(structure: Structure, other: Structure) -> list[Suspect]:
    """Effects that one structure holds and the other does not."""
    keys = {each.key for each in other.effects}
    return [each for each in structure.effects if each.key not in keys]
