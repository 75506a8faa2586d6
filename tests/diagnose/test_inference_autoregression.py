"""Autoregressions of one equation's rows, against processes whose covariance is known."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.linalg import solve_toeplitz, toeplitz

from flexdyn.diagnose.inference.autoregression import MOST_ORDER, Autoregression, runs_of

Array = NDArray[np.float64]
COEFFICIENTS, SCALE = (1.5, -0.8), 3.0
"""Of a stationary process of order 2, whose poles are at 0.89."""


def _series(count: int, seed: int) -> Array:
    """The process, after a start that has been forgotten."""
    x = np.zeros(count + 500)
    noise = SCALE * np.random.default_rng(seed).standard_normal(len(x))
    for k in range(2, len(x)):
        x[k] = COEFFICIENTS[0] * x[k - 1] + COEFFICIENTS[1] * x[k - 2] + noise[k]
    return x[500:]


def _autocovariance(count: int) -> Array:
    """Of the process by its response to an impulse: ``gamma(l) = s^2 sum_k h_k h_(k+l)``."""
    h = np.zeros(1000)
    h[0], h[1] = 1.0, COEFFICIENTS[0]
    for k in range(2, len(h)):
        h[k] = COEFFICIENTS[0] * h[k - 1] + COEFFICIENTS[1] * h[k - 2]
    return SCALE**2 * np.array([h[: len(h) - lag] @ h[lag:] for lag in range(count)])


def _exact(order: int) -> Autoregression:
    """The best predictors of every order by the normal equations, not by a recursion."""
    gamma = _autocovariance(order + 1)
    table, variance = np.zeros((order + 1, order)), [gamma[0]]
    for k in range(1, order + 1):
        table[k, :k] = solve_toeplitz(gamma[:k], gamma[1 : k + 1])
        variance.append(gamma[0] - table[k, :k] @ gamma[1 : k + 1])
    return Autoregression(table, np.sqrt(variance))


def _runs(count: int) -> NDArray[np.intp]:
    """Of one series without gaps."""
    return np.arange(count, dtype=np.intp)


def test_a_known_process_is_recovered_across_gaps() -> None:
    """Coefficients, scale and order where a fifth of the rows is hidden, and what is hidden does not matter."""
    series, hidden = _series(8000, 0), np.zeros(8000, bool)
    for k in range(0, 8000, 100):
        hidden[k : k + 20] = True
    series[hidden] = 1e6
    runs = runs_of(hidden, [8000], 1)[:, 0]
    found = Autoregression.of(series, runs)
    wanted = np.zeros(found.order)
    wanted[:2] = COEFFICIENTS
    np.testing.assert_allclose(found.predictors[-1], wanted, atol=0.04)
    assert found.order <= 4
    assert found.scale[-1] == pytest.approx(SCALE, rel=0.03)
    assert found.scale[0] ** 2 == pytest.approx(_autocovariance(1)[0], rel=0.1)


def test_innovations_of_an_estimated_process_are_white() -> None:
    """Unit variance and no autocorrelation beyond chance, on data that did not estimate it."""
    process = Autoregression.of(_series(8000, 1), _runs(8000))
    e = process.innovations(_series(8000, 2)[:, None], _runs(8000))[:, 0]
    assert e.var() == pytest.approx(1.0, abs=0.05)
    alike = [float((e[lag:] * e[:-lag]).mean()) for lag in range(1, 20)]
    assert np.abs(alike).max() < 4.0 / np.sqrt(len(e))


def test_innovations_factor_the_covariance() -> None:
    """``W Sigma W^T = I``, exactly, from the first row on."""
    process, count = _exact(2), 12
    covariance = toeplitz(_autocovariance(count))
    W = process.innovations(np.eye(count), _runs(count))
    np.testing.assert_allclose(W @ covariance @ W.T, np.eye(count), atol=1e-9)


def test_every_run_between_hidden_rows_begins_anew() -> None:
    """Two runs are two blocks of the covariance; hidden rows are zero."""
    hidden = np.zeros(12, bool)
    hidden[5:7] = True
    runs = runs_of(hidden, [12], 1)[:, 0]
    assert runs.tolist() == [0, 1, 2, 3, 4, -1, -1, 0, 1, 2, 3, 4]
    process, block = _exact(2), toeplitz(_autocovariance(5))
    W = process.innovations(np.eye(12), runs)
    for part in (slice(0, 5), slice(7, 12)):
        np.testing.assert_allclose(W[part, part] @ block @ W[part, part].T, np.eye(5), atol=1e-9)
    assert not W[hidden].any()
    assert not W[7:, :5].any()


def test_runs_end_with_a_recording_and_are_counted_by_equation() -> None:
    """Two recordings of three times and two equations, one row hidden."""
    hidden = np.zeros((6, 2), bool)
    hidden[1, 1] = True
    assert runs_of(hidden.ravel(), [3, 3], 2).T.tolist() == [[0, 1, 2, 0, 1, 2], [0, -1, 0, 0, 1, 2]]


def test_noise_of_the_sensors_alone_is_left_as_it_is() -> None:
    """Innovations never have less than the sensors' noise: evidence is not made larger by a good fit."""
    series = 0.5 * np.random.default_rng(3).standard_normal(2000)
    found = Autoregression.of(series, _runs(2000))
    assert found.order == 0
    np.testing.assert_array_equal(found.scale, [1.0])
    np.testing.assert_array_equal(found.innovations(series[:, None], _runs(2000))[:, 0], series)


def test_too_few_rows_estimate_no_more_than_a_size() -> None:
    """Fewer pairs than the greatest order has coefficients."""
    found = Autoregression.of(_series(MOST_ORDER, 6), _runs(MOST_ORDER))
    assert found.order == 0
