"""Waves over position of which the residual tells the harmonic, along a motion that is known in closed form."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from flexdyn.diagnose.data.filters import Filters
from flexdyn.diagnose.data.measured import measured
from flexdyn.diagnose.equations.equations import Equations
from flexdyn.diagnose.inference.autoregression import runs_of
from flexdyn.diagnose.inference.harmonics import HIGHEST_HARMONIC, SPECTRUM_PEAKS, peaks
from tests.diagnose.truths import Levels, slider_model, slider_recording

Array = NDArray[np.float64]
RATE, MASS, SECONDS = 500.0, 2.5, 30.0
LEVELS = Levels(1e-6, 0.05)
PARTS = ((1.1, 0.83, 0.0), (0.6, 1.94, 1.0), (0.2, 4.1, 2.0))
"""Amplitude, angular frequency and phase of the motion's parts."""


def _motion(t: Array) -> tuple[Array, Array]:
    """Position and acceleration."""
    x = sum((a * np.sin(w * t + p) for a, w, p in PARTS), np.zeros_like(t))
    return x, sum((-a * w**2 * np.sin(w * t + p) for a, w, p in PARTS), np.zeros_like(t))


def _found(folder: Path, waves: tuple[tuple[float, float], ...], slow: float = 0.0) -> tuple[list[float], float]:
    """Peaks with waves of such harmonics and amplitudes, and the resolution of the spectrum.

    Args:
        folder: for the model.
        waves: harmonic and amplitude of each.
        slow: amplitude of a slow force of time, that no wave of position makes.
    """
    t = np.arange(round(SECONDS * RATE)) / RATE
    x, _ = _motion(t)
    held, a = _motion(t + 0.5 / RATE)  # a force is held from one sample to the next
    force = MASS * a + slow * np.sin(0.4 * t)
    for harmonic, amplitude in waves:
        force = force + amplitude * np.sin(harmonic * held + 0.4)
    model = slider_model(folder)
    data = (measured(model, slider_recording(x, force, RATE, LEVELS, seed=7)),)
    equations = Equations(model, data, Filters.of_rate(1.0 / RATE))
    rows = len(equations.residual)
    runs = runs_of(np.zeros(rows, bool), [rows], 1)[:, 0]
    return peaks(equations, equations.residual, runs, 0, "q"), np.pi / float(np.ptp(x))


@pytest.mark.parametrize("harmonic", [3.4, 11.3, 37.77])
def test_a_harmonic_that_is_no_whole_number_is_the_highest_peak(tmp_path: Path, harmonic: float) -> None:
    """In noise, much nearer than the spectrum's resolution."""
    found, resolution = _found(tmp_path, ((harmonic, 0.2),))
    assert 1 <= len(found) <= SPECTRUM_PEAKS
    assert found[0] == pytest.approx(harmonic, abs=0.13 * resolution)


def test_two_waves_are_two_peaks(tmp_path: Path) -> None:
    """One of a third of the other's amplitude, beside a slow force that is larger than both."""
    found, resolution = _found(tmp_path, ((7.2, 0.3), (24.6, 0.1)), slow=1.0)
    for harmonic in (7.2, 24.6):
        assert min(abs(h - harmonic) for h in found) < 0.2 * resolution


def test_friction_over_position_has_its_peak_where_the_direction_counts(tmp_path: Path) -> None:
    """Over a motion to and fro, a spectrum that does not know of the direction has two peaks beside the harmonic."""
    t, harmonic = np.arange(round(SECONDS * RATE)) / RATE, 23.0
    x, _ = _motion(t)
    held, a = _motion(t + 0.5 / RATE)
    direction = np.sign(_motion(t + 0.51 / RATE)[0] - _motion(t + 0.49 / RATE)[0])
    force = MASS * a + 0.2 * np.sin(harmonic * held + 0.4) * direction
    data = (measured(slider_model(tmp_path), slider_recording(x, force, RATE, LEVELS, seed=7)),)
    equations = Equations(slider_model(tmp_path), data, Filters.of_rate(1.0 / RATE))
    rows = len(equations.residual)
    runs = runs_of(np.zeros(rows, bool), [rows], 1)[:, 0]
    one, other = (peaks(equations, equations.residual, runs, 0, "q", with_direction=each) for each in (True, False))
    near = 0.2 * np.pi / float(np.ptp(x))
    assert abs(one[0] - harmonic) < near
    assert min(abs(h - harmonic) for h in other) > near


def test_peaks_are_harmonics_that_are_looked_for(tmp_path: Path) -> None:
    """Of noise alone as well."""
    found, _ = _found(tmp_path, ())
    assert len(found) <= SPECTRUM_PEAKS
    assert all(1.0 <= h <= HIGHEST_HARMONIC for h in found)


def test_a_joint_that_rests_has_no_harmonics(tmp_path: Path) -> None:
    """Nothing is said about position where all rows are hidden."""
    model = slider_model(tmp_path)
    t = np.arange(1000) / RATE
    data = (measured(model, slider_recording(_motion(t)[0], np.zeros(1000), RATE, LEVELS, seed=8)),)
    equations = Equations(model, data, Filters.of_rate(1.0 / RATE))
    nothing = np.full(len(equations.residual), -1, np.intp)
    assert peaks(equations, equations.residual, nothing, 0, "q") == []
