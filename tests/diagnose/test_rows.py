"""Rows that the core filters and makes white, against dense algebra."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.linalg import cholesky_banded

from flexdyn import _core
from flexdyn.diagnose.data.filters import Filters
from flexdyn.diagnose.equations.covariance import Whitener

ROWS = 60


def _whitener(width: int, masked: tuple[int, ...] = ()) -> tuple[Whitener, np.ndarray]:
    """Of a covariance with a band, and the covariance."""
    draw = np.random.default_rng(width)
    band = 0.3 * draw.standard_normal((width, ROWS)) / np.arange(1, width + 1)[:, None]
    band[0] = 5.0 + draw.random(ROWS)
    below = [np.diag(line[: ROWS - d], -d) for d, line in enumerate(band)]
    covariance = sum(below[1:], below[0]) + sum((each.T for each in below[1:]), np.zeros((ROWS, ROWS)))
    by_columns = np.ascontiguousarray(cholesky_banded(band, lower=True).T)
    factor = np.empty_like(by_columns)
    _core.by_rows(by_columns, factor)
    mask = np.zeros(ROWS, bool)
    mask[list(masked)] = True
    return Whitener(factor, mask), covariance


def test_the_band_of_the_noise_is_that_of_the_dense_covariance() -> None:
    """Rows are sums of terms, coefficient times noise; the noises have covariances over lags; what is there is kept."""
    draw = np.random.default_rng(1)
    times, count, many, lags = 9, 3, 2, 4
    terms, weights = draw.standard_normal((times, count, many)), draw.standard_normal((lags, count, count))
    weights[1, 2], weights[:, 0, 1] = 0.0, 0.0
    wanted = np.zeros((times * many, times * many))
    pairs = [(t, lag) for t in range(times) for lag in range(min(lags, times - t))]
    for t, lag in pairs:
        block = terms[t + lag].T @ weights[lag] @ terms[t]
        wanted[(t + lag) * many : (t + lag + 1) * many, t * many : (t + 1) * many] = block
    band = np.ones((times * many, lags * many + 1))
    _core.noise_band(terms, weights, band)
    for d in range(band.shape[1]):
        below = np.diagonal(wanted, -d)
        np.testing.assert_allclose(band[: len(below), d] - 1.0, below, atol=1e-13)
        np.testing.assert_array_equal(band[len(below) :, d], 1.0)


@pytest.mark.parametrize("width", [1, 2, 7, 40])
@pytest.mark.parametrize("columns", [0, 1, 15, 16, 33])
def test_white_rows_are_those_of_the_dense_factor(width: int, columns: int) -> None:
    """Of one column or of many at once; masked rows are zero."""
    whiten, covariance = _whitener(width, masked=(3, 4, 59))
    raw = np.random.default_rng(0).standard_normal((ROWS, columns))
    wanted = np.linalg.solve(np.linalg.cholesky(covariance), raw)
    wanted[[3, 4, 59]] = 0.0
    np.testing.assert_allclose(whiten(raw), wanted, atol=1e-13)


def test_a_column_is_the_same_alone_and_among_others() -> None:
    """Bit for bit, so that no answer depends on what else was asked for."""
    whiten, _ = _whitener(9)
    raw = np.random.default_rng(1).standard_normal((ROWS, 21))
    white = whiten(raw)
    for k in range(21):
        np.testing.assert_array_equal(whiten(raw[:, k]), white[:, k])


@pytest.mark.parametrize("equations", [1, 3])
def test_columns_are_written_where_they_are_kept(equations: int) -> None:
    """The equations one after another, among other columns, in single precision."""
    whiten, _ = _whitener(5, masked=(7,))
    raw = np.random.default_rng(2).standard_normal((4, ROWS))
    kept = np.full((equations, 9, ROWS // equations), 8.0, np.float32)
    whiten.apart(raw, kept[:, 3:7])
    wanted = whiten(raw.T).reshape(-1, equations, 4).transpose(1, 2, 0)
    np.testing.assert_array_equal(kept[:, 3:7], wanted.astype(np.float32))
    assert (kept[:, [0, 1, 2, 7, 8]] == 8.0).all()


@pytest.mark.parametrize("order", [0, 1, 2])
@pytest.mark.parametrize("columns", [1, 3, 8, 11])
def test_rows_are_a_correlation_at_every_few_samples(order: int, columns: int) -> None:
    """Each column by itself, to the last row that the samples allow."""
    filters = Filters.of_rate(0.001)
    x = np.random.default_rng(3).standard_normal((400, columns))
    rows = filters.rows(x, order)
    for k in range(columns):
        whole = np.correlate(x[:, k], filters.second.taps[order])[:: filters.every]
        scale = np.abs(filters.second.taps[order]).sum()
        np.testing.assert_allclose(rows[:, k], whole[: len(rows)], atol=1e-14 * scale)
    assert len(rows) == filters.count(400)
