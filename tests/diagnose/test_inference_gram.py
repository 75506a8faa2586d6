"""Posteriors of structures from the equations' products, against dense algebra of the rows and integration."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray
from scipy.integrate import quad
from scipy.stats import multivariate_normal, norm

from flexdyn.diagnose.inference import eliminated
from flexdyn.diagnose.inference.evidence import NEGATIVE_SIGMAS, Prior
from flexdyn.diagnose.inference.gram import Estimate, Gram
from flexdyn.diagnose.inference.products import Products

Array = NDArray[np.float64]
ROWS, COLUMNS, BASE = 30, 8, 2
ABSENT = {0: (1, 6), 1: (3,), 2: (4, 5, 6)}
"""Columns that are zero in an equation; column 6 is in one equation alone."""


@dataclasses.dataclass(frozen=True, eq=False)
class Problem:
    """Rows of three equations.

    Attributes:
        X: (equations, rows, columns).
        y: (equations, rows).
        weights: of the equations' squares.
        prior: of all coefficients.
    """

    X: Array
    y: Array
    weights: Array
    prior: Prior

    @classmethod
    def of(cls, seed: int, *, positive: tuple[int, ...] = (), centred: tuple[int, ...] = ()) -> Problem:
        """Some columns may not be negative, some have a mean of 0."""
        draw = np.random.default_rng(seed)
        X = draw.standard_normal((3, ROWS, COLUMNS))
        X[:, :, 5] += 0.9 * X[:, :, 4]  # two that are alike
        X = X.astype(np.float32).astype(float)  # as they are kept
        for k, absent in ABSENT.items():
            X[k, :, list(absent)] = 0.0
        y = X @ draw.normal(0.0, 0.5, COLUMNS) + draw.standard_normal((3, ROWS))
        mean = draw.normal(0.0, 0.5, COLUMNS)
        mean[[*positive, *centred]] = 0.0
        bounded = np.zeros(COLUMNS, bool)
        bounded[list(positive)] = True
        return cls(X, y, draw.uniform(0.02, 2.0, 3), Prior(draw.uniform(0.3, 4.0, COLUMNS), mean, bounded))

    def empty(self) -> Products:
        """Of no column yet."""
        found = Products(len(self.y), ROWS, COLUMNS)
        found.explain(self.y.T)
        return found

    def products(self, *until: int) -> Products:
        """Of the columns, taken in up to such numbers one after another."""
        found = self.empty()
        for first, last in zip((0, *until), (*until, COLUMNS), strict=True):
            self.take(found, first, last)
        return found

    def take(self, products: Products, first: int, last: int) -> None:
        """Take some of the columns in."""
        table = self.X[:, :, first:last].transpose(0, 2, 1)
        assert products.put(first, table.astype(np.float32)) == last

    def gram(self, base: int = BASE, used: int = COLUMNS) -> Gram:
        """Under the problem's weights."""
        products = self.empty()
        self.take(products, 0, used)
        return Gram(products, self.weights, self.prior, base)

    def posterior(self, columns: list[int]) -> tuple[Array, Array]:
        """Mean and covariance by least squares on all rows, those of the priors below them."""
        root = np.sqrt(self.weights)[:, None]
        own = np.sqrt(self.prior.precision[columns])
        rows = np.concatenate([(root[:, :, None] * self.X[:, :, columns]).reshape(-1, len(columns)), np.diag(own)])
        right = np.concatenate([(root * self.y).ravel(), own * self.prior.mean[columns]])
        inverse = np.linalg.pinv(rows)
        return inverse @ right, inverse @ inverse.T

    def log_density(self, columns: list[int], shift: Array | float = 0.0) -> float:
        """Of the rows with the coefficients integrated out, but for the constants of pi and of the weights."""
        Z = self.X[:, :, columns].reshape(-1, len(columns))
        noise = np.repeat(1.0 / self.weights, ROWS)
        covariance = Z @ np.diag(1.0 / self.prior.precision[columns]) @ Z.T + np.diag(noise)
        rows = (self.y - shift).ravel()
        found = multivariate_normal.logpdf(rows, Z @ self.prior.mean[columns], covariance)
        return float(found) + 0.5 * float(np.log(2.0 * np.pi * noise).sum())

    def log_evidence(self, gram: Gram, own: Estimate) -> float:
        """What a volume says of the rows: with the squares at the coefficients, the density of the rows."""
        columns, mean = gram.with_base(own)
        off = mean - self.prior.mean[columns]
        left = self.y - self.X[:, :, columns] @ mean
        squares = float(self.weights @ (left**2).sum(axis=1)) + float(off @ (self.prior.precision[columns] * off))
        return own.log_volume - 0.5 * squares


def _at(*columns: int) -> NDArray[np.intp]:
    return np.array(columns, np.intp)


@pytest.mark.parametrize("columns", [(), (2,), (3, 6), (6,), (2, 4, 5, 7)])
def test_volumes_and_squares_are_the_density_of_the_rows(columns: tuple[int, ...]) -> None:
    """Any structure, with the columns that all have, under weights that differ by equation."""
    problem = Problem.of(0)
    gram = problem.gram()
    found = problem.log_evidence(gram, gram.estimate(_at(*columns)))
    assert found == pytest.approx(problem.log_density([0, 1, *columns]), rel=1e-10)


@settings(deadline=None, max_examples=40)
@given(seed=st.integers(0, 10_000), chosen=st.permutations(range(BASE, COLUMNS)), count=st.integers(0, 6))
def test_the_posterior_is_that_of_all_rows_at_once(seed: int, chosen: list[int], count: int) -> None:
    """Mean, covariance and volume of any structure, its columns in any order."""
    problem = Problem.of(seed)
    gram, own = problem.gram(), _at(*chosen[:count])
    found = gram.whole(own)
    columns = [*range(BASE), *chosen[:count]]
    mean, covariance = problem.posterior(columns)
    assert found.columns.tolist() == columns
    np.testing.assert_allclose(found.mean, mean, atol=1e-9)
    np.testing.assert_allclose(found.covariance, covariance, atol=1e-9)
    volume = 0.5 * np.linalg.slogdet(covariance * problem.prior.precision[columns])[1]
    assert found.log_volume == pytest.approx(volume, abs=1e-9)
    alone = gram.estimate(own)
    np.testing.assert_allclose(alone.mean, mean[BASE:], atol=1e-9)
    np.testing.assert_allclose(alone.covariance, covariance[BASE:, BASE:], atol=1e-9)
    assert alone.log_volume == found.log_volume
    order, both = gram.with_base(alone)
    assert order.tolist() == columns
    np.testing.assert_allclose(both, mean, atol=1e-9)
    left = problem.y - problem.X[:, :, columns] @ mean
    np.testing.assert_allclose(gram.squares(alone), (left**2).sum(axis=1), rtol=1e-9)


def test_pairs_are_kept_as_structures_come(monkeypatch: pytest.MonkeyPatch) -> None:
    """One structure after another, with room for one column at first: each as by all rows at once."""
    monkeypatch.setattr(eliminated, "FIRST_ROOM", 1)
    problem = Problem.of(11)
    gram = problem.gram()
    for own in (_at(4), _at(2, 4), _at(2, 5), _at(4, 5), _at(2, 3, 4, 5, 6, 7), _at(7, 2)):
        made, columns = gram.estimate(own), [*range(BASE), *own.tolist()]
        mean, covariance = problem.posterior(columns)
        np.testing.assert_allclose(made.mean, mean[BASE:], atol=1e-9)
        np.testing.assert_allclose(made.covariance, covariance[BASE:, BASE:], atol=1e-9)
        left = problem.y - problem.X[:, :, columns] @ mean
        np.testing.assert_allclose(gram.squares(made), (left**2).sum(axis=1), rtol=1e-9)


def test_columns_of_every_structure_may_be_eliminated_or_not() -> None:
    """The same volume and the same posterior with and without Schur's complement."""
    problem = Problem.of(2, positive=(3,))
    one, other = problem.gram().whole(_at(3, 6)), problem.gram(base=0).estimate(_at(0, 1, 3, 6))
    assert one.log_volume == pytest.approx(other.log_volume, rel=1e-10)
    np.testing.assert_allclose(one.mean, other.mean, atol=1e-10)
    np.testing.assert_allclose(one.covariance, other.covariance, atol=1e-10)


@pytest.mark.parametrize("seed", range(4))
def test_a_coefficient_that_may_not_be_negative_is_integrated_over_what_it_may_be(seed: int) -> None:
    """A half-normal prior: the density of the rows given the coefficient, integrated from 0 on."""
    problem = Problem.of(seed, positive=(4,))
    gram = problem.gram()
    found = problem.log_evidence(gram, gram.estimate(_at(3, 4)))
    spread = 1.0 / math.sqrt(problem.prior.precision[4])

    def height(b: float) -> float:
        rest = problem.log_density([0, 1, 3], b * problem.X[:, :, 4])
        return math.exp(rest - found) * 2.0 * float(norm.pdf(b, 0.0, spread))

    total = quad(height, 0.0, 8.0 * spread, limit=200, points=[0.1 * spread, spread])[0]
    assert total == pytest.approx(1.0, rel=1e-6)


def test_a_truncated_prior_is_normalised_where_its_mean_is_not_zero() -> None:
    """Part of the normal is below zero, and not half of it."""
    problem = Problem.of(3)
    bounded = problem.prior.positive.copy()
    bounded[4] = True
    problem.prior.mean[4] = 0.4
    bent = dataclasses.replace(problem, prior=dataclasses.replace(problem.prior, positive=bounded))
    mean, covariance = problem.posterior([0, 1, 4])
    above = norm.sf(0.0, mean[2], math.sqrt(covariance[2, 2])) / norm.sf(0.0, 0.4, problem.prior.precision[4] ** -0.5)
    change = bent.gram().estimate(_at(4)).log_volume - problem.gram().estimate(_at(4)).log_volume
    assert change == pytest.approx(math.log(above), abs=1e-9)


@pytest.mark.parametrize("there", [(), (2,), (2, 7)])
def test_additions_are_differences_of_densities(there: tuple[int, ...]) -> None:
    """Groups of one and of two columns; a column that may not be negative has the share of it that may be."""
    problem = Problem.of(4, positive=(3,), centred=(4,))
    problem.y[:] += 0.3 * problem.X[:, :, 3]  # a coefficient that is not far below zero
    singles, pairs = [(3,), (4,), (6,)], [(4, 5), (5, 6), (3, 6)]
    found = problem.gram().additions(_at(*there), [np.array(singles), np.array(pairs)])
    before, wanted = problem.log_density([0, 1, *there]), []
    for group in (*singles, *pairs):
        columns = [0, 1, *there, *group]
        gain = problem.log_density(columns) - before
        if 3 in group:
            mean, covariance = problem.posterior(columns)
            k = columns.index(3)
            gain += norm.logsf(0.0, mean[k], math.sqrt(covariance[k, k])) + math.log(2.0)
        wanted.append(gain)
    np.testing.assert_allclose(found, wanted, rtol=1e-9, atol=1e-9)


def test_an_addition_far_below_its_bound_is_none() -> None:
    """A coefficient that the rows put many standard deviations below zero; one just inside the bound is compared."""
    problem = Problem.of(5, positive=(3,))
    mean, covariance = problem.posterior([0, 1, 3])
    spread = math.sqrt(covariance[2, 2])
    # Rows made of column 3 move the coefficient by a known part of what is put in.
    moved = dataclasses.replace(problem, y=problem.y + problem.X[:, :, 3]).posterior([0, 1, 3])[0][2] - mean[2]
    for ratio, finite in ((-NEGATIVE_SIGMAS - 0.1, False), (-NEGATIVE_SIGMAS + 0.1, True)):
        size = (ratio * spread - mean[2]) / moved
        there = dataclasses.replace(problem, y=problem.y + size * problem.X[:, :, 3])
        assert np.isfinite(there.gram().additions(_at(), [np.array([[3]])])[0]) == finite


@pytest.mark.parametrize("until", [(5, 7), (3,), (2, 3, 4, 5, 6, 7)])
def test_columns_that_come_later_are_as_good(until: tuple[int, ...]) -> None:
    """Products and their sums that grew, against some that were whole from the beginning and dense algebra."""
    problem = Problem.of(6)
    products = problem.empty()
    grown: Gram | None = None
    for first, last in zip((0, *until), (*until, COLUMNS), strict=True):
        problem.take(products, first, last)
        if grown is None:
            grown = Gram(products, problem.weights, problem.prior, BASE)
        else:
            grown.grow()
    assert grown is not None
    whole = problem.gram()
    for columns in ((3, 5, 7), (2, 6), (6, 4, 2)):
        one, other = grown.whole(_at(*columns)), whole.whole(_at(*columns))
        assert one.log_volume == pytest.approx(other.log_volume, rel=1e-10)
        np.testing.assert_allclose(one.mean, other.mean, atol=1e-10)
        np.testing.assert_allclose(one.covariance, other.covariance, atol=1e-10)
        np.testing.assert_allclose(one.mean, problem.posterior([0, 1, *columns])[0], atol=1e-9)
    np.testing.assert_allclose(
        grown.additions(_at(3), [np.array([[6], [7]])]), whole.additions(_at(3), [np.array([[6], [7]])]), atol=1e-10
    )


def test_structures_do_not_see_columns_that_came_later() -> None:
    """What is known of a structure stays true as others grow."""
    problem = Problem.of(7)
    gram = problem.gram(used=5)
    before = gram.whole(_at(3, 4))
    problem.take(gram.products, 5, COLUMNS)
    gram.grow()
    after = gram.whole(_at(3, 4))
    assert before.log_volume == after.log_volume
    np.testing.assert_array_equal(before.mean, after.mean)


@settings(deadline=None, max_examples=40)
@given(seed=st.integers(0, 10_000), chosen=st.sets(st.integers(0, COLUMNS - 1)), until=st.integers(1, COLUMNS - 1))
def test_products_and_sums_are_those_of_the_rows(seed: int, chosen: set[int], until: int) -> None:
    """Of each equation, formed from the rows, with columns that are not in it; in any order of the columns."""
    problem = Problem.of(seed)
    draw = np.random.default_rng(seed)
    columns = draw.permutation(sorted(chosen)).astype(np.intp)
    values = draw.standard_normal(len(columns))
    products = problem.products(until)
    np.testing.assert_allclose(products.sum(columns, values), problem.X[:, :, columns] @ values, atol=1e-12)
    whole = np.einsum("eri,erj->eij", problem.X, problem.X)
    np.testing.assert_allclose(products.of(columns, columns[:2]), whole[:, columns][:, :, columns[:2]], atol=1e-12)
    np.testing.assert_allclose(products.diagonals(), np.einsum("eii->ei", whole), atol=1e-12)


def test_weights_count_rows() -> None:
    """An equation of weight 2 is that equation twice, and one of weight 0 is not there."""
    problem = Problem.of(8)
    one = Gram(problem.products(), np.array([2.0, 1.0, 0.0]), problem.prior, BASE).whole(_at(2, 4, 7))
    places = [0, 1, 0]
    twice = dataclasses.replace(problem, X=problem.X[places], y=problem.y[places])
    other = Gram(twice.products(), np.ones(3), problem.prior, BASE).whole(_at(2, 4, 7))
    assert one.log_volume == pytest.approx(other.log_volume, rel=1e-12)
    np.testing.assert_allclose(one.mean, other.mean, atol=1e-12)
    np.testing.assert_allclose(one.covariance, other.covariance, atol=1e-12)


def test_reserved_columns_take_room() -> None:
    """Also those that nobody puts: what is kept must not run beyond the end."""
    products = Products(1, 4, 3)
    products.reserve(2)
    assert products.room == 1
    products.put(0, np.ones((1, 1, 4), np.float32))
    assert products.room == 0
