"""The matrix of the candidates for one model error, which grows with refined grid points: evidence of any structure."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterable, Sequence

import numpy as np
from numpy.typing import NDArray
from scipy.special import betaln, log_ndtr

from flexdyn.diagnose.inference.candidate import Candidate, Column
from flexdyn.diagnose.inference.discrepancy import Discrepancy, Seen
from flexdyn.diagnose.inference.gram import NEGATIVE_SIGMAS, Estimate, Gram, Prior
from flexdyn.diagnose.inference.library import Library
from flexdyn.diagnose.inference.priors import EFFECT_TORQUE_SHARE, EVERY_MOTOR
from flexdyn.diagnose.inference.products import Products
from flexdyn.diagnose.lazy import lazy
from flexdyn.effects import Effect, registered

Array = NDArray[np.float64]
Indices = NDArray[np.intp]
Structure = frozenset[tuple[int, int]]
"""Candidates that a structure holds, each with its grid point."""
PLACE_BETA = (0.3, 6.0)
"""Beta prior of the share of places that have an effect: odds of 1 to 20 for a single place, better if other places
have it already.

So an effect of many joints costs less than single effects (Scott and Berger, 2010).
"""
UBIQUITOUS_BETA, PLAIN_BETA = (6.0, 0.3), (1.0, 1.0)
"""The same of friction that every motor has, where the file has none: odds of some 20 to 1; and of the same friction on
links: any share of the places is as likely as any other."""
NEGLIGIBLE_SHARE = 3e-3
"""Standard deviation of a negligible effect over that of a real one [1]: 0.1 % of the joint's torque."""
WHOLE_NUMBER_LOG_ODDS = 5.0
"""Log odds of a harmonic that is a whole number, or a whole number of motor turns, to one that is not."""
SPARE_COLUMNS = 400
"""Columns for refined grid points."""


class Space:
    """Candidates, their columns and the products of these under a model error.

    Args:
        library: that makes the columns.
        rows: what the start leaves, white but for the model error (rows,).
        seen: rows that say something.
    """

    def __init__(self, library: Library, rows: Array, seen: Seen) -> None:
        self.library, self.seen = library, seen
        times, many = seen.valid.shape
        capacity = library.most_columns() + SPARE_COLUMNS
        self.products = Products(many, times, capacity)
        self.candidates, made = library.candidates(self.products)
        always, small = library.always(), self._negligible(made)
        self.base = len(always.std) + sum(len(each.std) for each, _ in small)
        shift = self.base - len(always.std)
        for candidate in self.candidates:
            candidate.columns = [each + shift for each in candidate.columns]
        standing = [column for each, column in zip(self._owners(), made, strict=True) if each.stands is not None]
        rows = rows - sum((each.white[:, 0] for each in standing), np.zeros_like(rows))
        self.products.explain(-rows.reshape(times, many))
        self.size, self.cost, self.gained = np.zeros(capacity), np.zeros(capacity), np.zeros(capacity)
        self.smallest, self.of = np.zeros(capacity), np.zeros(capacity, np.intp)
        self.prior = Prior(np.ones(capacity), np.zeros(capacity), np.zeros(capacity, bool))
        self._put(0, always)
        self.used = self.base
        for column in made:
            self.used = self._put(self.used, column)
        place = len(always.std)
        for column, alike in small:
            place = self._put(place, column, alike + self.base)
        self.of[: self.used] = self.products.diagonals().argmax(axis=0)
        self.places = self._counted(self.candidates)

    def _negligible(self, made: list[Column]) -> list[tuple[Column, Indices]]:
        """Small amounts of every law without nonlinear parameters: no model is free of them; they are no findings.

        Each with its place among the columns that were made.
        """
        found, first = [], 0
        for candidate, column in zip(self._owners(), made, strict=True):
            here = np.arange(first, first + len(column.std))
            first += len(column.std)
            proposal = candidate.proposal
            if proposal is None or len(proposal.grid) > 1 or proposal.fixed:
                continue
            if candidate.stands:
                column, here = _tangents(column), here[1:]
            std = NEGLIGIBLE_SHARE * np.minimum(column.std, EFFECT_TORQUE_SHARE / np.maximum(column.size, 1e-300))
            mean, free = np.zeros_like(column.mean), column.positive & False
            found.append((dataclasses.replace(column, std=std, mean=mean, positive=free), here))
        return found

    def _owners(self) -> list[Candidate]:
        """The candidate of each block of columns."""
        return [candidate for candidate in self.candidates for _ in candidate.columns]

    @staticmethod
    def _counted(candidates: Iterable[Candidate]) -> dict[str, int]:
        places: dict[str, int] = {}
        for each in candidates:
            places[each.group] = places.get(each.group, 0) + 1
        return places

    def _put(self, first: int, column: Column, alike: Indices | None = None) -> int:
        """Take a block of columns in, which may be there elsewhere; the place after it."""
        if alike is None:
            end = self.products.put(first, column.apart, column.kept)
        else:
            end = self.products.again(first, alike)
        here = slice(first, end)
        self.prior.precision[here], self.prior.mean[here] = 1.0 / column.std**2, column.mean
        self.prior.positive[here], self.smallest[here] = column.positive, column.smallest
        self.size[here] = column.size
        if end > first:
            self.cost[first], self.gained[first] = column.log_jacobian, column.gained
        return end

    def under(self, noise: Discrepancy) -> None:
        """Compare under a model error from now on."""
        self.noise = noise
        self.known: dict[Structure, float] = {}
        self.weigh(noise)

    def forget(self) -> None:
        """Drop the columns; what was compared stays known."""
        del self.products, self.gram

    def weigh(self, noise: Discrepancy) -> None:
        """Take coefficients under the weights of another model error; how many rows tell one thing stays."""
        weights = 1.0 / (noise.scale**2 * self.noise.times)
        self.gram = Gram(self.products, weights, self.prior, self.base)

    def tempered(self, column: int) -> float:
        """Independent pieces of evidence in a row of the equation that a column is about most [1]."""
        return 1.0 / float(self.noise.times[self.of[column]])

    def grow(self, c: int, point: tuple[float, ...]) -> int | None:
        """Another grid point of a candidate; its place, or None where it does nothing."""
        candidate = self.candidates[c]
        if candidate.proposal is None:
            return None
        if point in candidate.points:
            return candidate.points.index(point)
        column = self.library.columns(candidate.proposal, point)
        if column is None or self.used + len(column.std) > len(self.size) or len(column.std) > self.products.room:
            return None
        first, self.used = self.used, self._put(self.used, column)
        self.of[first : self.used] = self.products.diagonals()[:, first:].argmax(axis=0)
        self.gram.grow()
        candidate.points.append(point)
        candidate.columns.append(np.arange(first, self.used))
        return len(candidate.points) - 1

    def columns(self, structure: Structure) -> Indices:
        """Columns of a structure's candidates (k,)."""
        parts = [self.candidates[c].columns[p] for c, p in sorted(structure)]
        return np.concatenate([np.zeros(0, np.intp), *parts]).astype(np.intp)

    def estimate(self, structure: Structure) -> Estimate:
        """A structure's posterior, the columns of every structure first."""
        return self.gram.whole(self.columns(structure))

    def value(self, structure: Structure) -> float:
        """Log posterior of a structure, not normalised, the size of its model error the most likely one; remembered."""
        if structure not in self.known:
            own = self.gram.estimate(self.columns(structure))
            columns, mean = self.gram.with_base(own)
            squares = self.products.squares(columns, mean)
            off = mean - self.prior.mean[columns]
            value = self.noise.log_likelihood(squares) - 0.5 * float(off @ (self.prior.precision[columns] * off))
            self.known[structure] = value + self.log_volume(structure, own) + self.log_large(structure, own)
        return self.known[structure]

    def log_volume(self, structure: Structure, own: Estimate | None = None) -> float:
        """What a structure's posterior has beside likelihood and priors at the best numbers: Occam's factor.

        Sizes of effects do not count here: whether they are large enough is a matter of the data that measure them.

        Args:
            structure: candidates with their grid points.
            own: its coefficients; None: they are estimated.
        """
        own = own or self.gram.estimate(self.columns(structure))
        return own.log_volume + self.log_prior(structure) + self._log_positive(structure, own)

    def _log_positive(self, structure: Structure, own: Estimate) -> float:
        """Log probability that masses, stiffnesses, dampings and levels of the file are positive, less that before.

        Only of numbers that are so little known that the normal prior does not say so.
        """
        loose = [k for k in self.loose if (k, 0) not in structure]
        if not loose:
            return 0.0
        mean, spread = self.gram.of_base(own, np.array(loose, np.intp))
        numbers = list(self.library.start.factors.items())
        start = np.array([numbers[k][1] for k in loose])
        tolerance = np.array([numbers[k][0].tolerance for k in loose])
        return float((log_ndtr((start + mean) / spread) - log_ndtr(1.0 / tolerance)).sum())

    @lazy
    def loose(self) -> tuple[int, ...]:
        """Numbers of the file whose prior reaches below zero: their places."""
        return tuple(k for k, n in enumerate(self.library.start.factors) if n.tolerance * NEGATIVE_SIGMAS > 1.0)

    def log_large(self, structure: Structure, own: Estimate) -> float:
        """Log probability that every effect is large enough to be one: the prior leaves out negligible sizes."""
        first, total = 0, 0.0
        for c, p in sorted(structure):
            columns = self.candidates[c].columns[p]
            here = slice(first, first + len(columns))
            first += len(columns)
            number = self.candidates[c].number
            if number is not None:  # a mass, a stiffness, a level: its factor is positive
                mean, spread = float(own.mean[here][0]), float(np.sqrt(own.covariance[here, here][0, 0]))
                factor = self.library.start.factors[number] + mean
                total += float(log_ndtr(factor / max(spread, 1e-12)))
                continue
            if self.gained[columns[0]] > 0.0:
                # The rows are in applied torque: those of recorded torque have the density of (1 + gain) times as much.
                rows = self.gained[columns[0]] * self.tempered(columns[0])
                total += rows * math.log(max(1.0 + float(own.mean[here][0]), 0.01))
            weight = self.size[columns]
            share = self.share(c, columns, own.mean[here]) * self._own_part(c, columns, own.mean[here])
            spread = float(np.sqrt((weight**2 * np.diag(own.covariance)[here]).sum()))
            total += float(log_ndtr((share - self.smallest[columns[0]]) / max(spread, 1e-12)))
        return total

    def share(self, c: int, columns: Indices, mean: Array) -> float:
        """Root mean square torque of a candidate over that of its joint; an effect that stands has its present one."""
        parts = self.size[columns] * mean
        return float(np.linalg.norm(parts if self.candidates[c].stands is None else parts[:1]))

    def _own_part(self, c: int, columns: Indices, mean: Array) -> float:
        """Share of an effect that the plainer one which it contains cannot do [1]: it must be large by itself."""
        plain = self.contained.get(c, ())
        return self._apart(columns, mean, [self.candidates[k].columns[0] for k in plain]) if plain else 1.0

    def own_share(self, structure: Structure, c: int, other: int) -> float:
        """Share of its joint's torque that a candidate of a structure has and another one in its place cannot make [1].

        Beside what every structure has: the file's numbers, and a small amount of every law, which stands for what no
        model resolves.
        """
        own = self.gram.estimate(self.columns(structure))
        columns = self.candidates[c].columns[dict(structure)[c]]
        place = {int(k): value for k, value in zip(own.columns, own.mean, strict=True)}
        mean = np.array([place[int(k)] for k in columns])
        return self.share(c, columns, mean) * self._apart(columns, mean, [self.candidates[other].columns[0]])

    def _apart(self, columns: Indices, mean: Array, others: Sequence[Indices]) -> float:
        """Share of what some columns do that others cannot [1]."""
        between, there = self.gram.between, np.concatenate(others)
        whole = float(mean @ between(columns, columns) @ mean)
        cross = between(there, columns) @ mean
        explained = float(cross @ np.linalg.lstsq(between(there, there), cross, rcond=1e-9)[0])
        return math.sqrt(min(max(1.0 - explained / max(whole, 1e-300), 0.0), 1.0))

    @lazy
    def contained(self) -> dict[int, tuple[int, ...]]:
        """The plainer laws at the same place that each candidate contains."""
        found = {}
        for c, each in enumerate(self.candidates):
            names = each.law.plainer
            found[c] = tuple(k for k, other in enumerate(self.candidates) if other.kind in names and _same(each, other))
        return found

    def best(self) -> Structure:
        """The most likely of those compared."""
        return max(self.known, key=lambda s: (self.known[s], sorted(s)))

    def log_prior(self, structure: Structure) -> float:
        """Log prior of a structure; the points of a candidate's grid are equally likely."""
        total = self.log_places(structure)
        for c, p in structure:
            candidate = self.candidates[c]
            total += self.costs(c, p) - math.log(candidate.choices)
            if "harmonic" in candidate.names and candidate.stands is None:
                total -= (
                    0.0
                    if candidate.points[p][0] in candidate.natural(candidate.points[p][0])
                    else WHOLE_NUMBER_LOG_ODDS
                )
        return total

    def log_places(self, structure: Structure) -> float:
        """Log prior of which laws are where: ``log B(m + a, n - m + b) - log B(a, n + b)`` for m of n places of a kind.

        It is what is believed of drives beforehand, whatever the data say.
        """
        chosen: dict[str, int] = {}
        for c, _ in structure:
            chosen[self.candidates[c].group] = chosen.get(self.candidates[c].group, 0) + 1
        total = 0.0
        for kind, m in chosen.items():
            n, (a, b) = self.places[kind], odds_of(kind)
            total += float(betaln(m + a, n - m + b) - betaln(a, n + b))
        return total

    def costs(self, c: int, p: int) -> float:
        """What a law that forgets the recorded torque costs."""
        column = int(self.candidates[c].columns[p][0])
        return float(self.cost[column]) * self.tempered(column)

    def left(self, structure: Structure) -> Array:
        """What a structure leaves, white but for the model error (rows,)."""
        columns, mean = self.gram.with_base(self.gram.estimate(self.columns(structure)))
        return np.asarray((self.products.sum(columns, mean) - self.products.y).T.ravel())


def _same(one: Candidate, other: Candidate) -> bool:
    """Whether two candidates act on the same joint and side, the other one as it is in the catalogue."""
    places = [tuple(each.place.get(key) for key in ("joint", "side")) for each in (one, other)]
    return places[0] == places[1] and other.stands is None


def _tangents(column: Column) -> Column:
    """Of an effect that stands, without what it does as it is."""
    return Column(column.apart[:, 1:], column.std[1:], column.mean[1:], column.positive[1:], column.size[1:])


def odds_of(group: str) -> tuple[float, float]:
    """Beta prior of the share of places at which effects of a group are."""
    if group.startswith(EVERY_MOTOR):
        return UBIQUITOUS_BETA
    return PLAIN_BETA if registered().get(group, Effect).prevalence == "everywhere" else PLACE_BETA
