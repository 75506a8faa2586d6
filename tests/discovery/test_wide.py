"""Wider ranges: what is drawn from them, and that recordings and models say so."""

from __future__ import annotations

import dataclasses

import cases
import numpy as np
import pytest
import sizes
import wide
from arm_draw import draw_arm, inertia_at
from excitation import KINDS, wanted_of
from make import build, ending
from recording import averaged
from visible import visible

SHORT = 8.0, 4.0


def scale(rng: np.random.Generator, tolerance: float, factor: float) -> sizes.Scale:
    """Of the elbow of some arm."""
    arm, one = draw_arm(rng), np.ones(2)
    found = sizes.Scale(rng, factor, 1, arm, 0, 50.0 * one, one, 0.01 * one, -one, one, inertia_at(arm))
    return dataclasses.replace(found, tolerance=tolerance, wide=True)


def test_wrong_numbers_are_beyond_three_tolerances() -> None:
    """Whatever the tolerance and the size of the effect."""
    rng = np.random.default_rng(0)
    for tolerance in (0.01, 0.03, 0.1):
        for factor in (1.0, 0.3):
            logs = [np.log(wide.wrong_factor(scale(rng, tolerance, factor))) for _ in range(50)]
            assert np.abs(logs).min() > 3.0 * tolerance


def test_harmonics_and_springs_fill_their_ranges() -> None:
    """Whole numbers and others from 1 to 200; two decades of stiffness."""
    rng = np.random.default_rng(1)
    one = scale(rng, 0.03, 1.0)
    waves = np.array([wide.harmonic(one) for _ in range(500)])
    assert waves.min() < 2.0
    assert 100.0 < waves.max() <= 200.0
    assert 0.6 < (waves == np.round(waves)).mean() < 0.8
    K = np.array([wide.springs(rng, draw_arm(rng)).stiffness for _ in range(200)])
    assert K.max() / K.min() > 100.0


@pytest.mark.parametrize("kind", KINDS)
def test_motions_begin_at_rest_and_stay_in_reach(kind: str) -> None:
    """Of every kind, at speeds and accelerations that a drive can follow."""
    rng = np.random.default_rng(2)
    styles = [wide.draw_style(rng) for _ in range(6)]
    middle = [0.5] * 6
    path = wanted_of(kind, rng, styles, middle, 20.0)
    assert path.shape == (20_000, 6)
    np.testing.assert_allclose(path[0], 0.5, atol=1e-3)
    speed = np.diff(path, axis=0) / 1e-3
    assert np.abs(speed[0]).max() < 1e-2
    for j, style in enumerate(styles):
        assert np.abs(path[:, j] - 0.5).max() <= 1.01 * style.reach + 0.05
        assert np.ptp(path[:, j]) > 0.0
        if kind in ("fourier", "single"):
            assert np.abs(speed[1200:, j]).max() < 1.01 * style.speed  # it fades in before


def test_a_wide_case_says_how_it_was_made() -> None:
    """Name, rate, tolerance; what is hidden shows; the ordinary family of the same seed stays what it is."""
    case = cases.make_case("single_wide", 5, 3, *SHORT)
    assert case.name == "single_wide_5_003"
    every = case.sensors.every
    assert every > 1
    fit = case.recordings["fit"]
    np.testing.assert_allclose(np.diff(fit["t"]), every * 1e-3)
    assert len(fit["tau.elbow"]) == len(fit["t"]) == round(SHORT[0] * 1000) // every
    assert all(visible(case, one) for one in case.hidden)
    made = build("single_wide", 5, 3, *SHORT, cases.sensors_of("single_wide"))
    assert f"tolerance: {case.tolerance!r}" in made["files"]["model.yaml"]
    ordinary = cases.make_case("single", 5, 3, *SHORT)
    assert (ordinary.sensors.every, ordinary.tolerance) == (1, 0.03)


def test_torques_are_averaged_from_sample_to_sample() -> None:
    """A held torque keeps its impulse; the last, shorter interval is averaged over what it has."""
    held = np.arange(10.0)
    np.testing.assert_allclose(averaged(held, 4), [1.5, 5.5, 8.5])
    assert averaged(held, 1) is held


def test_stops_of_rigid_joints_can_be_hidden() -> None:
    """A rigid joint has no spring to compare the stop with."""
    rng = np.random.default_rng(3)
    one = scale(rng, 0.03, 1.0)
    rigid = dataclasses.replace(one, arm=draw_arm(rng).replace(stiffness=(np.inf, np.inf)))
    stop = sizes.LINK["end_stop"](rigid)
    assert all(np.isfinite(value) for value in stop.values())


def test_families_are_called_wide_where_there_is_a_wider_one() -> None:
    """Published robots vary enough."""
    assert [ending(each, True) for each in ("single", "six", "published", "published_six")] == [
        "single_wide",
        "six_wide",
        "published",
        "published_six",
    ]
    assert ending("single", False) == "single"
