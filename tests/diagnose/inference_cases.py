"""Small sets of candidates whose columns are given, and their posteriors by dense algebra."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import lru_cache
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import quad
from scipy.optimize import minimize_scalar
from scipy.stats import beta, norm

from flexdyn.diagnose.constants import (
    EFFECT_TORQUE_SHARE,
    NEGLIGIBLE_SHARE,
    PLACE_BETA,
    UBIQUITOUS_BETA,
    WHOLE_NUMBER_LOG_ODDS,
)
from flexdyn.diagnose.hypothesis.hypothesis import Hypothesis
from flexdyn.diagnose.hypothesis.proposal import Point, Proposal
from flexdyn.diagnose.inference.candidate import Candidate, Column
from flexdyn.diagnose.inference.library import Library
from flexdyn.diagnose.inference.model_error import ModelError, Seen
from flexdyn.diagnose.inference.products import Products
from flexdyn.diagnose.inference.space import Space, Structure
from flexdyn.effects import Effect
from flexdyn.model.uncertain_parameters import FileNumber
from tests.arms import two_link
from tests.diagnose.truths import ARM

Array = NDArray[np.float64]
Numbers = float | Sequence[float] | Array
LENGTHS = (24, 16)
"""Rows of an equation in each recording."""
TIMES, EQUATIONS = sum(LENGTHS), 2
EXPECTED = ("viscous_friction", "coulomb_friction")
"""What every motor has."""


@dataclass(frozen=True, eq=False)
class Given:
    """One candidate, by its columns.

    Attributes:
        kind: of the effect, or the number's parameter.
        joint: that it acts on.
        columns: one for each grid point.
        points: of the grid.
        number: None for an effect.
        stands: the effect that the start holds.
    """

    kind: str
    joint: str
    columns: tuple[Column, ...]
    points: tuple[Point, ...] = ((),)
    number: FileNumber | None = None
    stands: Effect | None = None

    def proposal(self) -> Proposal | None:
        """One that makes no effects."""
        place = {"effect": self.kind, "joint": self.joint, "side": "motor"}
        return None if self.number else Proposal(place, lambda point, x: None, self.points, sizes=(1.0,))

    def negligible(self) -> Column | None:
        """The small amount of it that is in every structure, if any is."""
        if self.number is not None or len(self.points) > 1:
            return None
        (each,) = self.columns
        own = slice(0 if self.stands is None else 1, None)  # of what stands, its tangents
        usual = EFFECT_TORQUE_SHARE / np.maximum(
            each.size[own], 1e-300
        )  # of a drive, where the effect's own nature says more
        return column(each.white[:, own], NEGLIGIBLE_SHARE * np.minimum(each.std[own], usual))


def column(white: NDArray[np.floating[Any]], std: Numbers = 0.4, mean: Numbers = 0.0, size: Numbers = 1.0) -> Column:
    """Of rows (rows, width), its numbers free of bounds."""
    width = white.shape[1]
    wide = [np.broadcast_to(np.asarray(each, float), width).copy() for each in (std, mean, size)]
    return Column.of(white, EQUATIONS, wide[0], wide[1], wide[2])


@dataclass(frozen=True, eq=False)
class Dense:
    """A posterior by least squares on all rows, those of the priors below them.

    Attributes:
        X: columns of every structure, then those of the structure's candidates (rows, columns).
        y: what they explain (rows,).
        blocks: of the candidates, in the order of the structure sorted.
        own: where each of them is among the columns.
        std, prior: of the priors (columns,).
        mean, covariance: of the coefficients.
    """

    X: Array
    y: Array
    blocks: tuple[Column, ...]
    own: tuple[slice, ...]
    std: Array
    prior: Array
    mean: Array
    covariance: Array

    @property
    def left(self) -> Array:
        """What is left of a residual (rows,)."""
        return self.X @ self.mean - self.y

    @property
    def squares(self) -> Array:
        """Of what is left, summed over the rows of each equation (equations,)."""
        return np.asarray((self.left.reshape(-1, EQUATIONS) ** 2).sum(axis=0))


@dataclass(frozen=True, eq=False)
class Case:
    """Candidates and what the start leaves.

    Attributes:
        given: the candidates.
        always: numbers of the file.
        rows: residual of the start (rows of all equations,).
        valid: rows that say something (rows of an equation, equations).
        later: what a grid point that comes later adds.
        factors: of the file's numbers at the start.
    """

    given: tuple[Given, ...]
    always: Column
    rows: NDArray[np.floating[Any]]
    valid: NDArray[np.bool_] = field(default_factory=lambda: np.ones((TIMES, EQUATIONS), bool))
    later: Column | None = None
    factors: dict[FileNumber, float] = field(default_factory=dict)

    @property
    def seen(self) -> Seen:
        """Rows that say something."""
        return Seen(self.valid, LENGTHS)

    def noise(self, scale: Sequence[float] = (1.0, 1.0), times: Sequence[float] = (1.0, 1.0)) -> ModelError:
        """A model error of such a size and memory."""
        return ModelError(np.array(scale), np.array(times), self.valid.sum(axis=0).astype(float))

    def space(self, noise: ModelError | None = None) -> Space:
        """Under a model error; of none if it is not said."""
        candidates, columns, place = [], [], len(self.always.std)
        for each in self.given:
            at = []
            for block in each.columns:
                at.append(place + np.arange(len(block.std)))
                place += len(block.std)
                columns.append(block)
            candidates.append(
                Candidate(each.kind, each.proposal(), each.number, list(each.points), at, len(at), each.stands)
            )
        space = Space(GivenLibrary(self, candidates, columns), np.asarray(self.rows, float), self.seen)
        space.under(noise or self.noise())
        return space

    def block(self, c: int, p: int) -> Column:
        """Of a grid point, of which one may have come later."""
        points = self.given[c].columns
        found = points[p] if p < len(points) else self.later
        assert found is not None
        return found

    def dense(self, structure: Structure, noise: ModelError) -> Dense:
        """The posterior of a structure under the weights of a model error."""
        small = [each.negligible() for each in self.given]
        first = [self.always, *(each for each in small if each is not None)]
        blocks = [self.block(c, p) for c, p in sorted(structure)]
        X, std, prior = (
            np.concatenate([getattr(each, name) for each in (*first, *blocks)], axis=-1)
            for name in ("white", "std", "mean")
        )
        standing = [each.columns[0].white[:, 0] for each in self.given if each.stands is not None]
        y = sum(standing, np.zeros_like(self.rows)) - self.rows
        root = np.tile(1.0 / (noise.scale * np.sqrt(noise.times)), TIMES)
        inverse = np.linalg.pinv(np.concatenate([root[:, None] * X, np.diag(1.0 / std)]), rcond=1e-14)
        mean = inverse @ np.concatenate([root * y, prior / std])
        ends = np.cumsum([sum(len(each.std) for each in first), *(len(each.std) for each in blocks)]).tolist()
        own = tuple(slice(a, b) for a, b in pairwise(ends))
        return Dense(X, y, tuple(blocks), own, std, prior, mean, inverse @ inverse.T)

    def value(self, structure: Structure, noise: ModelError) -> float:
        """Log posterior of a structure but for what is the same of all: its parts one after another."""
        at = self.dense(structure, noise)
        off = (at.mean - at.prior) / at.std
        scaled = at.covariance / np.outer(at.std, at.std)
        total = 0.5 * float(np.linalg.slogdet(scaled)[1]) - 0.5 * float(off @ off)
        for block, own in zip(at.blocks, at.own, strict=True):
            spread = np.sqrt(np.diag(at.covariance)[own])
            above = norm.logsf(0.0, at.mean[own], spread) - norm.logsf(0.0, block.mean, block.std)
            total += float(above[block.positive].sum())
        sizes = zip(at.squares, noise.count, noise.times, strict=True)
        total += sum(float(n / t) * most_likely(float(s / n)) for s, n, t in sizes)
        return total + self.log_prior(structure, noise) + self.log_large(structure, noise)

    def log_prior(self, structure: Structure, noise: ModelError) -> float:
        """Of the places, the grid points and what a law costs that forgets the torque."""
        kinds = [each.kind for each in self.given]
        held = [self.given[c] for c, _ in structure]
        plain = {each.joint for each in self.given if each.kind == "coulomb_friction"}
        # Asymmetric friction is Coulomb friction too.
        implied = [each for each in held if each.kind == "asymmetric_friction" and each.joint in plain]
        chosen = [each.kind for each in held] + ["coulomb_friction"] * len(implied)
        total = 0.0
        for kind in set(chosen):
            n, odds = kinds.count(kind), UBIQUITOUS_BETA if kind in EXPECTED else PLACE_BETA
            total += math.log(share(chosen.count(kind), n, odds) / share(0, n, odds))
        for c, p in structure:
            each = self.given[c]
            total += self.block(c, p).log_jacobian / noise.times[most_about(self.block(c, p))]
            total -= math.log(len(each.columns))
            if each.kind == "torque_ripple" and p < len(each.points) and each.points[p][0] % 1.0:
                total -= WHOLE_NUMBER_LOG_ODDS
        return total

    def log_large(self, structure: Structure, noise: ModelError) -> float:
        """That every effect is large enough by itself, every number positive, and what a gain does to the density."""
        at, total = self.dense(structure, noise), 0.0
        for (c, _), block, own in zip(sorted(structure), at.blocks, at.own, strict=True):
            each, mean, variance = self.given[c], at.mean[own], np.diag(at.covariance)[own]
            if each.number is not None:
                total += float(norm.logcdf(self.factors[each.number] + mean[0], 0.0, math.sqrt(variance[0])))
                continue
            if block.gained:
                total += block.gained / noise.times[most_about(block)] * math.log1p(mean[0])
            size = math.sqrt(float(((block.size * mean) ** 2).sum())) * self.own_part(c, block.white @ mean, noise)
            spread = math.sqrt(float((block.size**2 * variance).sum()))
            total += float(norm.logcdf((size - block.smallest) / spread))
        return total

    def own_part(self, c: int, does: Array, noise: ModelError) -> float:
        """Share of what a law does that Coulomb friction at the same joint, and what all structures hold, cannot do."""
        me = self.given[c]
        plain = [
            each.columns[0].white
            for each in self.given
            if each.kind == "coulomb_friction" and each.joint == me.joint and each.stands is None
        ]
        if me.kind != "asymmetric_friction" or not plain:
            return 1.0
        base = self.dense(frozenset(), noise)
        root = np.tile(1.0 / (noise.scale * np.sqrt(noise.times)), TIMES)[:, None]

        def beside(table: Array) -> Array:  # what the base, within its priors, leaves of columns
            rows = np.concatenate([root * base.X, np.diag(1.0 / base.std)])
            right = np.concatenate([root * table, np.zeros((len(base.std), table.shape[1]))])
            return np.asarray(right - rows @ np.linalg.lstsq(rows, right, rcond=None)[0])

        mine, theirs = beside(does[:, None]), beside(np.concatenate(plain, axis=1))
        rest = mine - theirs @ np.linalg.lstsq(theirs, mine, rcond=None)[0]
        return float(np.linalg.norm(rest) / np.linalg.norm(mine))


class GivenLibrary(Library):
    """The library of a case: its columns are given, and not made of equations."""

    def __init__(self, case: Case, candidates: list[Candidate], columns: list[Column]) -> None:
        start = Hypothesis(two_link(ARM), case.factors)
        for name, value in {"start": start, "given": (case, candidates, columns)}.items():
            object.__setattr__(self, name, value)

    given: tuple[Case, list[Candidate], list[Column]]

    def most_columns(self) -> int:
        """Enough for those of the case."""
        case, _, columns = self.given
        return len(case.always.std) + 2 * sum(len(each.std) for each in columns)

    def candidates(self, products: Products) -> tuple[list[Candidate], list[Column]]:
        """Those of the case."""
        return self.given[1:]

    def always(self) -> Column:
        """Numbers of its file."""
        return self.given[0].always

    def columns(self, proposal: Proposal, point: Point) -> Column | None:
        """What a grid point that comes later adds."""
        return self.given[0].later


def most_likely(mean: float) -> float:
    """Log density of one row whose mean square is given, at its most likely scale of at least 1; by search."""
    best = minimize_scalar(
        lambda log: log + 0.5 * mean * math.exp(-2.0 * log),
        bounds=(0.0, 12.0),
        method="bounded",
        options={"xatol": 1e-9},
    )
    return -min(float(best.fun), 0.5 * mean)


@lru_cache
def share(m: int, n: int, odds: tuple[float, float] = PLACE_BETA) -> float:
    """Probability of an effect at m given ones of n places, that at each one having a Beta prior."""
    a, b = odds
    if b < a:  # the density's pole is at 1: of places without it the share has one at 0
        return share(n - m, n, (b, a))
    # With p = x^4 the density has no pole at 0.
    found = quad(
        lambda x: 4.0 * x**3 * x ** (4 * m) * (1.0 - x**4) ** (n - m) * float(beta.pdf(x**4, a, b)) if x else 0.0,
        0.0,
        1.0,
        epsabs=1e-13,
        epsrel=1e-11,
    )
    return float(found[0])


def most_about(block: Column) -> int:
    """The equation in which a column's first number does most."""
    return int((block.white[:, 0].reshape(-1, EQUATIONS) ** 2).sum(axis=0).argmax())


def in_order(case: Case, order: Sequence[int]) -> Case:
    """The same candidates in another order."""
    return replace(case, given=tuple(case.given[k] for k in order))
