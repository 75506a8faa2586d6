"""The posterior over sets of candidates, each with its best grid points, normalised over all compared sets."""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from flexdyn.arrays import Array
from flexdyn.diagnose.inference.space import Structure

Set = frozenset[int]


@dataclass(frozen=True, eq=False)
class Masses:
    """Sets of candidates, the most probable first.

    Attributes:
        sets: of places of candidates.
        structures: the best one of each set: its candidates with their grid points.
        log: of their posteriors, not normalised; of sets from other linearisations −infinity (sets,).
        probability: the same normalised over all of them (sets,).
    """

    sets: tuple[Set, ...]
    structures: tuple[Structure, ...]
    log: Array
    probability: Array

    @classmethod
    def of(cls, known: Mapping[Structure, float]) -> Masses:
        """Of log posteriors of structures, each a set of candidates with their grid points."""
        best: dict[Set, tuple[float, Structure]] = {}
        for structure, value in sorted(known.items(), key=lambda each: (-each[1], sorted(each[0]))):
            best.setdefault(frozenset(c for c, _ in structure), (value, structure))
        log = np.array([value for value, _ in best.values()])
        weight = np.exp(log - log[0])
        return cls(tuple(best), tuple(structure for _, structure in best.values()), log, weight / weight.sum())

    def mixed(self, others: Sequence[Set], odds: Sequence[float]) -> Masses:
        """The mixture with other linearisations: each gives one set with certainty, at odds to all that are here."""
        probability = dict(zip(self.sets, self.probability.tolist(), strict=True))
        for each, weight in zip(others, odds, strict=True):
            probability[each] = probability.get(each, 0.0) + weight
        new = [each for each in probability if each not in self.sets]
        structures = (*self.structures, *(frozenset((c, 0) for c in each) for each in new))
        log = np.append(self.log, np.full(len(new), -np.inf))
        masses = np.array(list(probability.values()))
        return Masses((*self.sets, *new), structures, log, masses / masses.sum())

    def without(self, left_out: Mapping[int, float]) -> Masses:
        """The same with some candidates less likely, the most probable first again.

        Args:
            left_out: by how much, in the logarithm, of every set that holds the candidate.
        """
        less = np.array([math.fsum(left_out.get(c, 0.0) for c in mine) for mine in self.sets])
        weight = self.probability * np.exp(less.min() - less)
        order = np.argsort(-weight, kind="stable").tolist()
        sets, structures = (tuple(each[k] for k in order) for each in (self.sets, self.structures))
        return Masses(sets, structures, (self.log - less)[order], weight[order] / weight.sum())

    def by_fits(self, tried: Sequence[tuple[Structure, Set, float]]) -> Masses:
        """The same where fits make sets more likely than they are here, the most probable first again.

        Args:
            tried: structures, each with another set and its odds to that by fits.
        """
        probability = dict(zip(self.sets, self.probability.tolist(), strict=True))
        log = dict(zip(self.sets, self.log.tolist(), strict=True))
        points = dict(zip(self.sets, self.structures, strict=True))
        for structure, whole, odds in tried:
            mine = frozenset(c for c, _ in structure)
            probability[mine] = max(probability.get(mine, 0.0), odds * probability.get(whole, 0.0))
            reached = log[whole] + math.log(odds) if odds > 0.0 and whole in log else -math.inf
            log[mine] = max(log.get(mine, -math.inf), reached)
            points.setdefault(mine, structure)
        order = sorted(probability, key=lambda mine: -probability[mine])
        masses = np.array([probability[mine] for mine in order])
        logs = np.array([log[mine] for mine in order])
        return Masses(tuple(order), tuple(points[mine] for mine in order), logs, masses / masses.sum())

    def place(self, holds: Collection[int], without: Collection[int] = ()) -> int | None:
        """Of the most probable set that holds some candidates and none of some others; None: there is none."""
        fits = (k for k, mine in enumerate(self.sets) if mine.issuperset(holds) and mine.isdisjoint(without))
        return next(fits, None)

    def of_any(self, candidates: Collection[int]) -> float:
        """Probability that at least one of some candidates is there."""
        holds = [not mine.isdisjoint(candidates) for mine in self.sets]
        return min(1.0, float(self.probability[holds].sum()))

    def log_bayes_factor(self, candidate: int) -> float:
        """Log posterior of the best set with a candidate less that of the best without it; infinite: there is none."""
        there, absent = self.place([candidate]), self.place((), [candidate])
        if there is None or absent is None:
            return np.inf if absent is None else -np.inf
        return float(self.log[there] - self.log[absent])

    @property
    def candidates(self) -> list[int]:
        """All that are in some set."""
        return sorted(frozenset().union(*self.sets))
