"""Quantiles over runs against NumPy's own; rank correlation and swings against closed forms."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pytest
from numpy.typing import NDArray

from flexdyn.batch import trajectory_views as module
from flexdyn.batch.summary import sensitivity
from flexdyn.batch.trajectory_views import HISTOGRAM_BINS, quantiles

Array = NDArray[np.float64]
SHARES = (0.05, 0.25, 0.5, 0.75, 0.95)


def in_blocks(values: Array, size: int) -> Iterator[Array]:
    """Some runs at a time."""
    return (values[first : first + size] for first in range(0, len(values), size))


def test_few_runs_are_exact() -> None:
    """Up to the limit they are NumPy's quantiles, whatever the blocks."""
    values = np.random.default_rng(0).normal(size=(37, 5, 2))
    found = quantiles(lambda: in_blocks(values, 4), len(values), SHARES)
    np.testing.assert_array_equal(found, np.quantile(values, SHARES, axis=0))


def test_many_runs_are_within_a_bin(monkeypatch: pytest.MonkeyPatch) -> None:
    """Beyond the limit nothing is held, and a quantile is off by less than a bin of the range at its instant."""
    monkeypatch.setattr(module, "EXACT", 100)
    rng = np.random.default_rng(1)
    values = rng.normal(size=(5000, 3, 2)) * np.array([1.0, 1e-3, 50.0])[:, None] + np.array([0.0, 7.0])
    values[:, 2, 1] = 4.0  # an instant at which nothing varies
    found = quantiles(lambda: in_blocks(values, 300), len(values), SHARES)
    bin_width = np.ptp(values, axis=0) / HISTOGRAM_BINS
    assert (np.abs(found - np.quantile(values, SHARES, axis=0)) <= 1.5 * bin_width + 1e-12).all()


def test_no_runs_have_no_quantiles() -> None:
    """Where no run is done there is nothing to say."""
    assert np.isnan(quantiles(lambda: iter(()), 0, SHARES)).all()


def test_ranks_of_equal_values_are_shared() -> None:
    """Two that are equal share the mean of their places."""
    x, y = np.array([3.0, 1.0, 3.0, 2.0]), np.array([1.0, 2.0, 3.0, 4.0])
    expected = np.corrcoef([2.5, 0.0, 2.5, 1.0], [0.0, 1.0, 2.0, 3.0])[0, 1]
    assert sensitivity(x, y).rank_correlation == pytest.approx(expected)  # type: ignore[union-attr]


def test_rank_correlation_sees_any_rise() -> None:
    """1 for every rising law, -1 for every falling one; runs without a metric do not count."""
    x = np.random.default_rng(2).uniform(size=200)
    rising, falling = np.exp(9.0 * x), -(x**3)
    rising[5] = np.nan
    assert sensitivity(x, rising).rank_correlation == pytest.approx(1.0)  # type: ignore[union-attr]
    assert sensitivity(x, falling).rank_correlation == pytest.approx(-1.0)  # type: ignore[union-attr]


def test_rank_correlation_is_that_of_scipy() -> None:
    """With noise and equal values."""
    from scipy.stats import spearmanr

    rng = np.random.default_rng(3)
    x = rng.integers(0, 7, 300).astype(float)
    y = x + rng.normal(size=300)
    found = sensitivity(x, y)
    assert found is not None
    assert found.rank_correlation == pytest.approx(spearmanr(x, y).statistic, rel=1e-12)


def test_chance_is_what_chance_makes() -> None:
    """Of studies in which nothing matters, 5 in 100 have a greater correlation than `chance`."""
    rng = np.random.default_rng(4)
    beyond = 0
    for _ in range(1000):
        found = sensitivity(rng.normal(size=60), rng.normal(size=60))
        assert found is not None
        beyond += abs(found.rank_correlation) > found.chance
    assert 30 <= beyond <= 70


def test_swing_of_a_straight_line() -> None:
    """Over x uniform on [0, 1], 3 x moves from -1.2 to 1.2 about its mean between the outer fifths."""
    x = (np.arange(10000) + 0.5) / 10000
    found = sensitivity(x, 3.0 * x)
    assert found is not None
    assert found.low == pytest.approx(-1.2, abs=1e-3)
    assert found.high == pytest.approx(1.2, abs=1e-3)


def test_nothing_is_said_where_nothing_varies() -> None:
    """A constant metric, a constant parameter, two runs."""
    x = np.arange(5.0)
    assert sensitivity(x, np.ones(5)) is None
    assert sensitivity(np.ones(5), x) is None
    assert sensitivity(x[:2], x[:2]) is None
