"""The Gaussian filters: exact on parabolas, silent on constants, and noise through them as computed."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from flexdyn.diagnose.data.filters import Filters, later
from flexdyn.diagnose.equations.held_torque import centred
from flexdyn.records.signals.kernels import GaussianSmoother


@settings(deadline=None)
@given(st.floats(1.0, 8.0), st.floats(-3.0, 3.0), st.floats(-3.0, 3.0), st.floats(-3.0, 3.0))
def test_parabolas_keep_their_derivatives(width: float, c: float, b: float, a: float) -> None:
    """First and second derivative of c + b t + a t^2, to rounding."""
    dt = 1e-3
    t = dt * np.arange(200, dtype=float)
    kernel = GaussianSmoother.of_width(width * dt, dt)
    x = c + b * t + a * t * t
    inner = t[kernel.half : len(t) - kernel.half]
    np.testing.assert_allclose(kernel.apply(x, 1), b + 2.0 * a * inner, atol=1e-9)
    np.testing.assert_allclose(kernel.apply(x, 2), 2.0 * a, atol=1e-5)


@pytest.mark.parametrize("width", [1.25, 2.0, 5.0])
def test_no_position_leaks_into_a_velocity(width: float) -> None:
    """Taps of derivatives sum to zero, those of the value to one."""
    taps = GaussianSmoother.of_width(width * 1e-3, 1e-3).taps
    assert math.fsum(taps[0]) == pytest.approx(1.0, abs=1e-15)
    assert math.fsum(taps[1]) == pytest.approx(0.0, abs=1e-12 * np.abs(taps[1]).max())
    assert math.fsum(taps[2]) == pytest.approx(0.0, abs=1e-12 * np.abs(taps[2]).max())


@settings(deadline=None)
@given(st.integers(60, 300), st.integers(1, 7), st.integers(0, 2))
def test_rows_are_the_whole_filter_thinned(samples: int, every: int, order: int) -> None:
    """Filtering and keeping every so manieth row is what the fast path does, at the instants that it says."""
    kernel = GaussianSmoother.of_width(2e-3, 1e-3)
    filters = Filters(kernel, kernel, every)
    x = np.random.default_rng(samples).standard_normal((samples, 2))
    whole = kernel.apply(x, order)
    at = filters.instants(samples) - kernel.half
    np.testing.assert_allclose(filters.rows(x, order), whole[at], rtol=1e-9, atol=1e-9 * np.abs(whole).max())
    assert len(at) == filters.count(samples)


@pytest.mark.parametrize("rate", [125.0, 250.0, 1000.0])
def test_a_held_torque_is_what_it_accelerates(rate: float) -> None:
    """X'' = u with u held between samples, solved exactly: the mean of two samples falls short at slow rates."""
    t = np.arange(2000) / rate
    u = np.sin(2.0 * np.pi * 0.02 * rate * t) + 0.5 * np.sin(2.0 * np.pi * 0.005 * rate * t + 1.0)
    speed = np.concatenate([[0.0], np.cumsum(u[:-1]) / rate])
    x = np.concatenate([[0.0], np.cumsum(speed[:-1] / rate + 0.5 * u[:-1] / rate**2)])
    smoother = GaussianSmoother.of_width(1.25 / rate, 1.0 / rate)
    true, sharp = smoother.apply(x, 2), smoother.apply(centred(u), 0)
    mean = smoother.apply(np.concatenate([u[:1], 0.5 * (u[1:] + u[:-1])]), 0)
    inside = slice(20, -20)
    assert np.abs(sharp - true)[inside].max() < 0.1 * np.abs(mean - true)[inside].max()


def test_a_late_signal_is_not_smoothed() -> None:
    """By a part of a sample, against the signal itself; straight lines would smooth it."""
    t = np.arange(400) / 100.0
    x, late = np.sin(40.0 * t), 0.0137
    error = np.abs(later(t, x, late) - np.sin(40.0 * (t - late)))[20:-20].max()
    lines = np.abs(np.interp(t - late, t, x) - np.sin(40.0 * (t - late)))[20:-20].max()
    assert error < 0.1 * lines
    assert later(t, x, 1.0)[0] == x[0]
