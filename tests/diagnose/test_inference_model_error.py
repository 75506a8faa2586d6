"""Size and memory of a model error, against processes whose autocorrelations are known and direct maximisation."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray
from scipy.linalg import cholesky_banded, solve_triangular, toeplitz
from scipy.optimize import minimize_scalar
from scipy.signal import lfilter

from flexdyn import _core
from flexdyn.diagnose.equations.covariance import Whitener
from flexdyn.diagnose.inference.model_error import ModelError, Seen
from flexdyn.diagnose.inference.whitening import Tempered

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]


def _of(table: Array, hidden: Flags | None = None, lengths: tuple[int, ...] = ()) -> ModelError:
    """Of rows (rows of an equation,) or (rows of an equation, equations); one recording, all seen, if not said."""
    valid = np.ones(table.shape, bool) if hidden is None else ~hidden
    seen = Seen(valid.reshape(len(table), -1), lengths or (len(table),))
    return ModelError.of(table.ravel(), seen)


def _autoregressive(phi: float, count: int, seed: int) -> Array:
    """A stationary series whose autocorrelation is ``phi^k``, much larger than the sensors' noise."""
    noise = np.random.default_rng(seed).standard_normal(count + 500)
    return np.asarray(10.0 * lfilter([1.0], [1.0, -phi], noise)[500:])


@pytest.mark.parametrize("seed", range(5))
def test_white_rows_all_count(seed: int) -> None:
    """The sensors' noise alone: each row is evidence of its own."""
    found = _of(np.random.default_rng(seed).standard_normal(20_000))
    assert found.scale[0] == pytest.approx(1.0, abs=0.02)
    assert 1.0 <= found.times[0] < 1.1
    assert found.count[0] == 20_000


@pytest.mark.parametrize("phi", [0.5, 0.8, 0.9])
def test_an_autoregression_counts_no_more_than_bartlett_lets_it(phi: float) -> None:
    """``t = 1 + 2 sum phi^(2 k) = (1 + phi^2)/(1 - phi^2)``; chance correlations add 2 (t - 1) in the mean."""
    times = [_of(_autoregressive(phi, 20_000, seed)).times[0] for seed in range(8)]
    exact = (1.0 + phi**2) / (1.0 - phi**2)
    assert np.mean(times) == pytest.approx(3.0 * exact - 2.0, rel=0.15)
    assert min(times) > exact


def test_a_longer_memory_leaves_less_evidence() -> None:
    """Of series with the same number of rows."""
    times = [_of(_autoregressive(phi, 20_000, 1)).times[0] for phi in (0.0, 0.5, 0.8, 0.9, 0.97)]
    assert np.all(np.diff(times) > 0.5)


@pytest.mark.parametrize("turns", [2, 10, 100])
def test_a_sine_has_two_numbers_however_long_it_is(turns: int) -> None:
    """Its autocorrelation is a cosine: ``1 + 2 sum (1 - k/N) cos^2 = N/2``, so that N rows tell two things."""
    phase = 2.0 * np.pi * turns * np.arange(4000) / 4000
    found = _of(50.0 * np.sin(phase + 0.3))
    assert found.count[0] / found.times[0] == pytest.approx(2.0, rel=0.1)
    assert found.scale[0] == pytest.approx(50.0 / math.sqrt(2.0), rel=1e-6)


@pytest.mark.parametrize("smooth", [False, True])
def test_a_motion_that_is_made_again_tells_nothing_new(smooth: bool) -> None:
    """What is left comes again with each period of the motion: rows that say one thing grow as the rows do."""
    period = 20.0 * np.random.default_rng(3).standard_normal(200)
    if smooth:
        kernel = np.exp(-0.5 * (np.arange(-20, 21) / 5.0) ** 2)
        period = np.convolve(np.tile(period, 3), kernel, "same")[200:400]
    found = [_of(np.tile(period, again)) for again in (2, 4, 8, 16, 32)]
    evidence = np.array([float(each.count[0] / each.times[0]) for each in found])
    assert evidence.max() < 200
    assert evidence.max() < 1.6 * evidence.min()
    # Two further series of new rows, in comparison, tell as much each.
    new = [_of(20.0 * np.random.default_rng(4).standard_normal(200 * again)) for again in (2, 32)]
    assert new[1].count[0] / new[1].times[0] > 12.0 * new[0].count[0] / new[0].times[0]


def test_what_hidden_rows_hold_does_not_matter() -> None:
    """They are in no sum, and a sine that a third of is hidden still has two numbers."""
    draw = np.random.default_rng(5)
    hidden = draw.random(3000) < 0.33
    series = 40.0 * np.sin(2.0 * np.pi * 12.0 * np.arange(3000) / 3000)
    other = np.where(hidden, 1e6 * draw.standard_normal(3000), series)
    one, two = _of(series, hidden), _of(other, hidden)
    assert (one.scale[0], one.times[0], one.count[0]) == (two.scale[0], two.times[0], two.count[0])
    assert one.count[0] == (~hidden).sum()
    assert one.scale[0] ** 2 == pytest.approx((series[~hidden] ** 2).mean(), rel=1e-12)
    assert one.count[0] / one.times[0] == pytest.approx(2.0, rel=0.15)
    white = draw.standard_normal(20_000)
    assert _of(white, draw.random(20_000) < 0.33).times[0] < 1.15


def test_recordings_are_not_correlated_across() -> None:
    """The sign of a whole recording does not matter, as it would if its rows met those of another one."""
    one, other = _autoregressive(0.95, 300, 6), 1.0 + _autoregressive(0.95, 200, 7)
    same, turned = np.concatenate([one, other]), np.concatenate([one, -other])
    apart = [float(_of(series, lengths=(300, 200)).times[0]) for series in (same, turned)]
    joined = [float(_of(series).times[0]) for series in (same, turned)]
    assert apart[0] == pytest.approx(apart[1], rel=1e-12)
    assert abs(joined[0] - joined[1]) > 1.0


@settings(deadline=None, max_examples=40)
@given(
    seed=st.integers(0, 1000),
    lengths=st.lists(st.integers(1, 60), min_size=1, max_size=4),
    factor=st.floats(1.0, 1e3),
    pad=st.integers(0, 30),
)
def test_memory_has_no_unit_no_order_and_no_direction(seed: int, lengths: list[int], factor: float, pad: int) -> None:
    """Of rows in another unit, of recordings in another order, backwards in time, between rows that are hidden."""
    draw = np.random.default_rng(seed)
    parts = [lfilter([1e9], [1.0, -0.7], draw.standard_normal(n)) for n in lengths]  # far above the noise
    holes = [draw.random(n) < 0.2 for n in lengths]

    def times(order: list[int], turn: int = 1, scale: float = 1.0, more: int = 0) -> float:
        series = [np.pad(scale * parts[k][::turn], more, constant_values=7.0) for k in order]
        hidden = [np.pad(holes[k][::turn], more, constant_values=True) for k in order]
        rows = tuple(len(each) for each in series)
        return float(_of(np.concatenate(series), np.concatenate(hidden), rows).times[0])

    forth = list(range(len(parts)))
    wanted = times(forth)
    assert wanted >= 1.0
    for found in (times(forth[::-1]), times(forth, -1), times(forth, 1, factor), times(forth, more=pad)):
        assert found == pytest.approx(wanted, rel=1e-9)


@pytest.mark.parametrize("share", [0.9, 0.5, 0.1])
def test_rows_below_the_noise_remember_as_rows_of_noise_beside_them(share: float) -> None:
    """Rows of less noise than they are taken to have tell as much as if the rest of it were there, and white."""
    rows = np.sqrt(share) * _autoregressive(0.9, 200_000, 9) / np.std(_autoregressive(0.9, 200_000, 9))
    noisy = rows + np.sqrt(1.0 - share) * np.random.default_rng(10).standard_normal(len(rows))
    hidden = np.zeros(len(rows), bool)
    assert float(_of(rows, hidden).times[0]) == pytest.approx(float(_of(noisy, hidden).times[0]), rel=0.05)


def test_equations_do_not_mix() -> None:
    """Each has its own size, memory and rows, whatever the others do."""
    draw = np.random.default_rng(7)
    table = np.stack([_autoregressive(0.9, 4000, 8), draw.standard_normal(4000), np.zeros(4000)], axis=1)
    hidden = np.zeros(table.shape, bool)
    hidden[:500, 1] = True
    hidden[:, 2] = True
    found = _of(table, hidden)
    for k in (0, 1):
        alone = _of(table[:, k], hidden[:, k])
        assert (found.scale[k], found.times[k]) == pytest.approx((alone.scale[0], alone.times[0]), rel=1e-12)
    assert found.count.tolist() == [4000, 3500, 1]  # one that says nothing divides by nothing
    assert (found.scale[2], found.times[2]) == (1.0, 1.0)


@settings(deadline=None, max_examples=60)
@given(
    counts=st.lists(st.integers(5, 5000), min_size=1, max_size=3),
    means=st.lists(st.floats(1e-3, 1e4), min_size=3, max_size=3),
    times=st.lists(st.floats(1.0, 500.0), min_size=3, max_size=3),
)
def test_the_likelihood_is_that_of_the_most_likely_size(
    counts: list[int], means: list[float], times: list[float]
) -> None:
    """``max over s >= 1`` of the Gaussian log density of N/t independent rows, but for the constants."""
    many = len(counts)
    count, per_row, rows = np.array(counts, float), np.array(means[:many]), np.array(times[:many])
    noise = ModelError(np.full(many, 3.0), rows, count)
    wanted = 0.0
    for n, mean, t in zip(count, per_row, rows, strict=True):
        # Log density of one row by the logarithm of its scale, from 0 on.
        best = minimize_scalar(
            lambda log, mean=mean: log + 0.5 * mean * math.exp(-2.0 * log),
            bounds=(0.0, 10.0),
            method="bounded",
            options={"xatol": 1e-10},
        )
        wanted -= n / t * min(float(best.fun), 0.5 * mean)
    assert noise.log_likelihood(count * per_row) == pytest.approx(wanted, rel=1e-7)


def test_the_likelihood_falls_with_what_is_left() -> None:
    """Also below the sensors' noise, and without a step where the model error begins."""
    noise = ModelError(np.ones(1), np.full(1, 4.0), np.full(1, 100.0))
    values = np.array([noise.log_likelihood(np.array([s])) for s in np.linspace(0.0, 400.0, 4001)])
    steps = np.diff(values)
    assert np.all(steps < 0.0)
    assert np.abs(np.diff(steps)).max() < 1e-4


def test_white_rows_weigh_what_they_tell() -> None:
    """Their mean square is 1/times; below the sensors' noise they are not made larger."""
    table = np.stack([_autoregressive(0.8, 3000, 9), 0.5 * _autoregressive(0.0, 3000, 10) / 10.0], axis=1)
    found = _of(table)
    white = found.whiten(table.ravel()).reshape(table.shape)
    np.testing.assert_allclose((white**2).mean(axis=0) * found.times, [1.0, (table[:, 1] ** 2).mean()], rtol=1e-10)
    np.testing.assert_allclose((white**2).sum(axis=0), found.weights * (table**2).sum(axis=0), rtol=1e-10)
    columns = np.random.default_rng(11).standard_normal((table.size, 4))
    many = found.whiten(columns)
    for k in range(4):
        np.testing.assert_array_equal(many[:, k], found.whiten(columns[:, k]))


def test_sensors_whiten_before_the_model_error_tempers() -> None:
    """Against a dense factor of the noise's covariance; hidden rows stay zero."""
    covariance = toeplitz([4.0, 1.5, 0.5, *[0.0] * 9])
    hidden = np.zeros(12, bool)
    hidden[4] = True
    band = np.zeros((3, 12))
    for lag in range(3):
        band[lag, : 12 - lag] = np.diag(covariance, -lag)
    error = ModelError(np.array([2.0, 5.0]), np.array([3.0, 7.0]), np.array([6.0, 5.0]))
    rows = np.random.default_rng(12).standard_normal((12, 3))
    wanted = solve_triangular(np.linalg.cholesky(covariance), rows, lower=True)
    wanted[hidden] = 0.0
    wanted /= np.tile([2.0 * math.sqrt(3.0), 5.0 * math.sqrt(7.0)], 6)[:, None]
    factor = np.empty((12, 3))
    _core.by_rows(np.ascontiguousarray(cholesky_banded(band, lower=True).T), factor)
    found = Tempered.of(Whitener(factor, hidden), error)(rows)
    np.testing.assert_allclose(found, wanted, atol=1e-12)
