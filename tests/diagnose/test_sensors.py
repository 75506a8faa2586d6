"""Measured channels put right."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.interpolate import CubicSpline

from flexdyn.diagnose.data.sensors import advanced


@pytest.mark.parametrize("delay", [0.0, 3e-4, 1e-3, 4.7e-3, -2.3e-3, 0.25, 2.0, -2.0])
def test_what_is_early_is_a_cubic_spline_between_samples(delay: float) -> None:
    """By SciPy's spline, away from the ends; beyond them the first and the last value hold."""
    dt = 1e-3
    t = dt * np.arange(600)
    x = np.sin(9.0 * t) + 1e-3 * np.random.default_rng(0).standard_normal(600)
    found = advanced(x, delay, dt)
    there = t + delay
    inside = (there > t[20]) & (there < t[-20])
    np.testing.assert_allclose(found[inside], CubicSpline(t, x)(there[inside]), atol=1e-9)
    assert (found[there > t[-1] + 1e-9] == x[-1]).all()
    assert np.abs(found[there < t[0] - dt] - x[0]).max(initial=0.0) < np.abs(np.diff(x[:3])).max()
