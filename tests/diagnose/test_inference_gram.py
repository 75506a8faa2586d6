"""Marginal likelihoods from one Gram matrix, against the Gaussian of the rows and numerical integration."""

from __future__ import annotations

import math

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.integrate import quad
from scipy.stats import multivariate_normal, norm

from flexdyn.diagnose.inference.gram import Gram, Prior

Array = NDArray[np.float64]
ROWS, COLUMNS, BASE = 40, 8, 2


def _problem(seed: int, *, positive: tuple[int, ...] = (), centred: tuple[int, ...] = ()) -> tuple[Array, Array, Prior]:
    """Columns, rows and priors; some columns may not be negative, some have a mean of 0."""
    draw = np.random.default_rng(seed)
    X = draw.standard_normal((ROWS, COLUMNS))
    X[:, 5] += 0.9 * X[:, 4]  # two that are alike
    y = X @ draw.normal(0.0, 0.5, COLUMNS) + draw.standard_normal(ROWS)
    mean = draw.normal(0.0, 0.5, COLUMNS)
    mean[[*positive, *centred]] = 0.0
    bounded = np.zeros(COLUMNS, bool)
    bounded[list(positive)] = True
    return X, y, Prior(draw.uniform(0.3, 4.0, COLUMNS), mean, bounded)


def _log_density(X: Array, y: Array, prior: Prior, columns: list[int]) -> float:
    """Of the rows with the coefficients integrated out, but for the constant of pi."""
    Z = X[:, columns]
    covariance = Z @ np.diag(1.0 / prior.precision[columns]) @ Z.T + np.eye(ROWS)
    whole = multivariate_normal.logpdf(y, Z @ prior.mean[columns], covariance)
    return float(whole) + 0.5 * ROWS * math.log(2.0 * math.pi)


def _at(*columns: int) -> NDArray[np.intp]:
    return np.array(columns, np.intp)


@pytest.mark.parametrize("columns", [(), (2,), (3, 6), (2, 4, 5, 7)])
def test_the_marginal_likelihood_is_the_density_of_the_rows(columns: tuple[int, ...]) -> None:
    """Any structure, with the columns that all have."""
    X, y, prior = _problem(0)
    found = Gram(X, y, prior, BASE, COLUMNS).estimate(_at(*columns))
    wanted = _log_density(X, y, prior, [0, 1, *columns])
    assert found.log_likelihood == pytest.approx(wanted, rel=1e-10)


def test_the_posterior_is_that_of_ridge_regression() -> None:
    """Mean and covariance of all coefficients of a structure, by the normal equations."""
    X, y, prior = _problem(1)
    found = Gram(X, y, prior, BASE, COLUMNS).whole(_at(3, 4, 5))
    columns = [0, 1, 3, 4, 5]
    assert found.columns.tolist() == columns
    A = X[:, columns].T @ X[:, columns] + np.diag(prior.precision[columns])
    c = X[:, columns].T @ y + prior.precision[columns] * prior.mean[columns]
    np.testing.assert_allclose(found.mean, np.linalg.solve(A, c), atol=1e-10)
    np.testing.assert_allclose(found.covariance, np.linalg.inv(A), atol=1e-10)


def test_columns_of_every_structure_may_be_eliminated_or_not() -> None:
    """The same likelihood and the same posterior with and without Schur's complement."""
    X, y, prior = _problem(2, positive=(3,))
    apart, together = Gram(X, y, prior, BASE, COLUMNS), Gram(X, y, prior, 0, COLUMNS)
    one, other = apart.whole(_at(3, 6)), together.estimate(_at(0, 1, 3, 6))
    assert one.log_likelihood == pytest.approx(other.log_likelihood, rel=1e-10)
    np.testing.assert_allclose(one.mean, other.mean, atol=1e-10)
    np.testing.assert_allclose(one.covariance, other.covariance, atol=1e-10)


@pytest.mark.parametrize("seed", range(4))
def test_a_coefficient_that_may_not_be_negative_is_integrated_over_what_it_may_be(seed: int) -> None:
    """A half-normal prior: the density of the rows given the coefficient, integrated from 0 on."""
    X, y, prior = _problem(seed, positive=(4,))
    found = Gram(X, y, prior, BASE, COLUMNS).estimate(_at(3, 4)).log_likelihood
    spread = 1.0 / math.sqrt(prior.precision[4])

    def height(b: float) -> float:
        rest = _log_density(X, y - b * X[:, 4], prior, [0, 1, 3])
        return math.exp(rest - found) * 2.0 * float(norm.pdf(b, 0.0, spread))

    total = quad(height, 0.0, 8.0 * spread, limit=200, points=[0.1 * spread, spread])[0]
    assert total == pytest.approx(1.0, rel=1e-6)


@pytest.mark.parametrize("there", [(), (2,), (2, 7)])
def test_additions_are_differences_of_marginal_likelihoods(there: tuple[int, ...]) -> None:
    """Groups of one and of two columns, some of which may not be negative."""
    X, y, prior = _problem(4, positive=(3,), centred=(4,))
    y = y + X[:, 3]  # a coefficient that is not far below zero
    gram = Gram(X, y, prior, BASE, COLUMNS)
    singles, pairs = [(3,), (4,), (6,)], [(4, 5), (5, 6), (3, 6)]
    found = gram.additions(_at(*there), [np.array(singles), np.array(pairs)])
    before = gram.estimate(_at(*there)).log_likelihood
    wanted = [gram.estimate(_at(*there, *group)).log_likelihood - before for group in (*singles, *pairs)]
    np.testing.assert_allclose(found, wanted, rtol=1e-9, atol=1e-9)


def test_an_addition_far_below_its_bound_is_none() -> None:
    """A coefficient that the rows put many standard deviations below zero."""
    X, y, prior = _problem(5, positive=(3,))
    gram = Gram(X, y - 10.0 * X[:, 3], prior, BASE, COLUMNS)
    assert gram.additions(_at(), [np.array([[3]])])[0] == -np.inf


def test_columns_that_come_later_are_as_good() -> None:
    """A matrix that grew, against one that was whole from the beginning."""
    X, y, prior = _problem(6)
    whole, grown = Gram(X, y, prior, BASE, COLUMNS), Gram(X, y, prior, BASE, 5)
    grown.grow(7)
    grown.grow(COLUMNS)
    np.testing.assert_allclose(grown.G, whole.G, atol=1e-12)
    columns = _at(3, 5, 7)
    assert grown.estimate(columns).log_likelihood == pytest.approx(whole.estimate(columns).log_likelihood, rel=1e-12)
