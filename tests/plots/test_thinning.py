"""Thinning: of a long recording fewer points are drawn, and its outline stays."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from flexdyn.plots.thinning import FINE, MOST_CURVE_POINTS, MOST_PLANE_POINTS, SLICES, outline, outline_in_plane

Array = NDArray[np.float64]


def recording(seed: int, count: int, gap: float) -> tuple[Array, Array]:
    """Jittered times with a gap in the middle, and a walk with single spikes."""
    rng = np.random.default_rng(seed)
    t = np.cumsum(rng.uniform(0.5e-3, 1.5e-3, count))
    t[count // 2 :] += gap
    y = np.cumsum(rng.normal(size=count))
    y[rng.integers(0, count, 5)] += rng.choice([-1e3, 1e3], 5)
    return t, y


@settings(max_examples=25, deadline=None)
@given(
    seed=st.integers(0, 2**32 - 1),
    count=st.integers(MOST_CURVE_POINTS + 1, 20_000),
    gap=st.sampled_from([0.0, 0.5, 100.0]),
)
def test_every_slice_of_time_keeps_its_extremes(seed: int, count: int, gap: float) -> None:
    """Over any slice the least and greatest drawn value is that of all samples, and first and last sample stay."""
    t, y = recording(seed, count, gap)
    kept = outline(t, y)
    assert (np.diff(kept) > 0).all()
    assert {0, count - 1} <= set(kept.tolist())
    assert len(kept) <= 4 * SLICES
    place = np.minimum((SLICES * (t - t[0]) / (t[-1] - t[0])).astype(int), SLICES - 1)
    low, high = (np.full(SLICES, sign * np.inf) for sign in (1, -1))
    thin_low, thin_high = low.copy(), high.copy()
    np.minimum.at(low, place, y)
    np.maximum.at(high, place, y)
    np.minimum.at(thin_low, place[kept], y[kept])
    np.maximum.at(thin_high, place[kept], y[kept])
    # A sample on the very border of two slices may count to either, to rounding: then a few slices swap it.
    assert np.mean(low != thin_low) < 0.01
    assert np.mean(high != thin_high) < 0.01
    assert [y[kept].min(), y[kept].max()] == [y.min(), y.max()]


def test_short_recordings_stay_whole() -> None:
    """Up to the limit every sample is drawn, over time and in a plane."""
    t = np.linspace(0.0, 1.0, MOST_CURVE_POINTS)
    assert outline(t, np.sin(9.0 * t)).tolist() == list(range(MOST_CURVE_POINTS))
    assert outline_in_plane(np.cos(t), np.sin(t))[0].tolist() == list(range(MOST_CURVE_POINTS))


def test_a_line_in_a_plane_is_drawn_to_a_cell() -> None:
    """A slow spiral of 200 000 samples: no sample is farther than one cell from one that is drawn, and it is a line."""
    t = np.linspace(0.0, 20.0, 200_000)
    x, y = t * np.cos(t), t * np.sin(t)
    kept, dots = outline_in_plane(x, y)
    assert not dots
    assert len(kept) < len(t) / 5
    before = kept[np.searchsorted(kept, np.arange(len(t)), "right") - 1]
    cell = np.ptp(x) / FINE, np.ptp(y) / FINE
    assert (np.abs(x - x[before]) <= 1.001 * cell[0]).all()
    assert (np.abs(y - y[before]) <= 1.001 * cell[1]).all()


def test_a_plane_that_is_full_is_dots() -> None:
    """Where a line would need too many points, each cell that was visited has one dot, and the extremes are there."""
    t = np.linspace(0.0, 1.0, 300_000)
    x, y = (1.0 - t) * np.cos(9000.0 * t), (1.0 - t) * np.sin(9000.0 * t)
    kept, dots = outline_in_plane(x, y)
    assert dots
    assert MOST_PLANE_POINTS < len(kept) < len(t) / 5
    assert [x[kept].min(), x[kept].max(), y[kept].min(), y[kept].max()] == [x.min(), x.max(), y.min(), y.max()]


@pytest.mark.parametrize("level", [0.0, 3.5])
def test_a_constant_is_two_ends(level: float) -> None:
    """A signal that does not change over a long time is drawn by few points, all of them its level."""
    t = np.linspace(0.0, 10.0, 50_000)
    y = np.full(len(t), level)
    assert len(outline(t, y)) <= 2 * SLICES
    kept, dots = outline_in_plane(y, y)
    assert not dots
    assert (y[kept] == level).all()
