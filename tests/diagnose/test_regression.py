"""Least squares with priors, against NumPy on the stacked problem."""

from __future__ import annotations

import numpy as np
import pytest

from flexdyn.diagnose.hypothesis.regression import Regression


def problem(seed: int = 0, nuisances: int = 0) -> Regression:
    """200 rows, five columns with priors of different width."""
    draw = np.random.default_rng(seed)
    X = draw.standard_normal((200, 5))
    y = X @ np.array([0.5, -0.2, 0.0, 0.1, 1.0]) + draw.standard_normal(200)
    return Regression(
        y, X, np.array([0.1, 0.0, -0.2, 0.0, 0.3]), np.array([0.05, 1.0, 0.1, np.inf, 2.0]), 200, nuisances
    )


def stacked(made: Regression) -> tuple[np.ndarray, np.ndarray]:
    """Rows and priors as one least-squares problem A b = t."""
    A = np.vstack([made.X, np.diag(1.0 / made.sigma)])
    return A, np.concatenate([-made.y, made.centre / made.sigma])


def test_values_are_the_least_squares_ones() -> None:
    """And so is what is left, and the covariance."""
    made = problem()
    A, t = stacked(made)
    best = np.linalg.lstsq(A, t, rcond=None)[0]
    np.testing.assert_allclose(made.values, best, rtol=1e-9)
    assert made.chi2 == pytest.approx(float(((A @ best - t) ** 2).sum()))
    np.testing.assert_allclose(made.covariance, np.linalg.inv(A.T @ A), rtol=1e-8)


def test_tall_problems_are_solved_as_well() -> None:
    """Many more rows than columns, two of which are nearly the same."""
    draw = np.random.default_rng(3)
    X = draw.standard_normal((5003, 8))
    X[:, 7] = X[:, 6] + 1e-4 * draw.standard_normal(5003)
    made = Regression(draw.standard_normal(5003), X, np.zeros(8), np.full(8, 10.0), 5003)
    A, t = stacked(made)
    np.testing.assert_allclose(made.values, np.linalg.lstsq(A, t, rcond=None)[0], rtol=1e-7)
    np.testing.assert_allclose(made.covariance, np.linalg.inv(A.T @ A), rtol=1e-6)


def test_nuisances_are_fitted_even_where_no_step_is_taken() -> None:
    """The sum of squares at zero is that of the problem with the nuisance columns alone."""
    made = problem(nuisances=2)
    A, t = stacked(made)
    best = np.linalg.lstsq(A[:, 3:], t, rcond=None)[0]
    assert made.at_zero == pytest.approx(float(((A[:, 3:] @ best - t) ** 2).sum()))


def test_coloured_rows_widen_the_sandwich() -> None:
    """Rows that repeat in blocks say as little as one of them: the spread over draws is that of the sandwich."""
    block, blocks, sigma = 20, 100, np.full(2, np.inf)
    draw = np.random.default_rng(3)
    X = np.repeat(draw.standard_normal((blocks, 2)), block, axis=0)
    made = [
        Regression(np.repeat(draw.standard_normal(blocks), block), X, np.zeros(2), sigma, block * blocks)
        for _ in range(300)
    ]
    found = np.std([each.values for each in made], axis=0)
    told = np.sqrt(np.mean([np.diag(each.sandwich(block)) for each in made], axis=0))
    np.testing.assert_allclose(told, found, rtol=0.15)
    assert (np.sqrt(np.diag(made[0].covariance)) < 0.4 * found).all()
