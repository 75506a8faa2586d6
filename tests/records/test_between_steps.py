"""Positions between the steps of an encoder, against the motion that was read."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.ndimage import gaussian_filter1d

from flexdyn.arrays import Array
from flexdyn.records.signals.between_steps import between_steps

STEP, RATE, LEAST = 6e-6, 500.0, 16
T = np.arange(20000) / RATE


def _errors(x: Array) -> tuple[float, float]:
    """Root mean square errors of smoothed accelerations [rad/s^2]: of the readings, and of the positions between."""
    read = STEP * np.round(x / STEP)
    each = (gaussian_filter1d(y - x, 0.01 * RATE, order=2) * RATE**2 for y in (read, between_steps(read, LEAST)[0]))
    before, after = (float(np.sqrt(np.mean(error[100:-100] ** 2))) for error in each)
    return before, after


@pytest.mark.parametrize(
    ("motion", "share"),
    [
        (STEP * (5.0 * T + 0.3 * np.sin(3.0 * T)), 0.1),  # creeps by five steps a second
        (STEP * (RATE + 5.0) * T, 0.1),  # by one step per sample, and one more in a hundred
        (STEP * 25.0 * np.sin(0.3 * T), 0.2),  # turns back
    ],
)
def test_accelerations_of_regular_readings_are_far_more_exact(motion: Array, share: float) -> None:
    """Readings that jump now and then have accelerations of whole steps, and the motion has not."""
    before, after = _errors(motion)
    assert after < share * before


def test_a_joint_that_stops_between_the_borders_is_where_it_was_read() -> None:
    """Nothing tells where between them it stopped; on average that is in the middle."""
    rng, stops = np.random.default_rng(2), []
    for x in rng.uniform(-0.5, 0.5, 400):
        way = np.concatenate([np.linspace(-20.0, x, 20), np.full(200, x)])
        left = between_steps(STEP * np.round(np.concatenate([way, way[::-1]])), LEAST)[0] / STEP
        stops.append(left[60:380] - x)
    assert abs(np.mean(stops)) < 0.05
    assert np.std(stops) < 1.1 / np.sqrt(12.0)


def test_readings_with_other_noise_stay() -> None:
    """Noise dithers: a mean of readings is then more exact than their steps."""
    noise = np.random.default_rng(0).normal(0.0, 0.5 * STEP, len(T))
    read = STEP * np.round((STEP * 5.0 * T + noise) / STEP)
    assert between_steps(read, LEAST)[0] is read
    smooth = np.sin(T)
    assert between_steps(smooth, LEAST)[0] is smooth


@given(st.floats(-40.0, 40.0), st.floats(0.0, 300.0), st.floats(0.1, 20.0), st.integers(3, 60))
def test_positions_stay_within_half_a_step_of_the_readings(speed: float, size: float, rate: float, least: int) -> None:
    """Whatever the motion is."""
    t = np.arange(2000) / RATE
    read = STEP * np.round(speed * t + size * np.sin(rate * t))
    assert np.abs(between_steps(read, least)[0] - read).max() <= 0.5 * STEP * (1.0 + 1e-9)
