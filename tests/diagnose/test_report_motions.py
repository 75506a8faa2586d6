"""Measured and simulated motion in report.html: true to the numbers, movable, and small enough to be sent."""

from __future__ import annotations

import dataclasses
from pathlib import Path

import numpy as np
import pytest

from flexdyn.diagnose.report.pictures import motion_figures
from flexdyn.diagnose.report.trace import MOST_TRAJECTORY_POINTS, MeasuredCurve, Trajectory, packed_column
from tests.arms import repickled
from tests.browser import open_page
from tests.diagnose import report_cases as cases

LARGEST = 3_000_000
"""Bytes of a page (issue 28)."""


def drawn(joint: str, begin: float, end: float, rate: float, role: str, seed: int = 0) -> Trajectory:
    """A motion with noise and friction that is missing."""
    draw = np.random.default_rng(seed)
    t = np.arange(begin, end, 1.0 / rate)
    q = np.sin(t) + 0.3 * np.sin(7.3 * t + seed)
    off = 0.1 * np.sign(np.cos(t)) + 0.002 * draw.standard_normal((3, len(t)))
    off *= np.array([1.0, 0.9, 0.01])[:, None]
    off[:, ::97] = np.nan
    return Trajectory(
        joint,
        "monday",
        role,  # type: ignore[arg-type]
        MeasuredCurve("q [rad]", t, q, off),
        MeasuredCurve("torque [N m]", t, 30.0 * q, 9.0 * off),
    )


def test_a_packed_column_is_the_column() -> None:
    """Within half a level, and gaps stay gaps."""
    values = np.random.default_rng(1).standard_normal(500) * 1e-5
    values[[0, 7, 499]] = np.nan
    made = packed_column(values, levels=1000)
    level, found = 0, []
    for step in made["steps"]:
        level += step or 0
        found.append(np.nan if step is None else level * made["unit"])
    assert (np.isnan(found) == np.isnan(values)).all()
    assert np.nanmax(np.abs(np.array(found) - values)) <= 0.51 * np.nanmax(np.abs(values)) / 1000
    assert packed_column([np.nan, np.nan])["steps"] == [None, None]
    assert packed_column([0.0, 0.0])["steps"] == [0, 0]


def test_a_thinned_curve_keeps_its_peaks() -> None:
    """One sample that stands out among many survives, and the ends."""
    long = drawn("elbow", 0.0, 60.0, 1000.0, "fit").torque
    errors = long.errors.copy()
    errors[2, 31_234] = 77.0
    few = MeasuredCurve(long.label, long.t, long.measured, errors).thinned(3000)
    assert len(few.t) <= 3000 * 1.3
    assert np.nanmax(few.errors[2]) == 77.0
    assert (few.t[0], few.t[-1]) == (long.t[0], long.t[-1])
    assert (np.diff(few.t) > 0.0).all()
    again = repickled(few)
    assert (again.t == few.t).all()
    assert not again.t.flags.writeable


def test_a_minute_of_six_joints_is_below_three_megabytes(tmp_path: Path) -> None:
    """Drawn data of 1 kHz with eighteen laws and thirty-six residuals; noise packs worst of all."""
    robot = cases.robot()
    given = [
        drawn(joint, begin, end, 1000.0, role, seed)
        for seed, joint in enumerate(robot.model.joint_names)
        for role, begin, end in (("test", 48.0, 60.0), ("fit", 0.0, 48.0))
    ]
    found = robot.findings + robot.findings[:6]
    full = dataclasses.replace(robot, trajectories=tuple(given), findings=found, residuals=robot.residuals * 3)
    full.save(tmp_path)
    assert len((tmp_path / "report.html").read_bytes()) < LARGEST
    assert sum(len(each["columns"]) for each in motion_figures(full)) > 100


def test_the_window_moves_and_shows_what_was_given(tmp_path: Path) -> None:
    """Joint, data, length and place of the window are chosen; curves are measured, and measured plus error."""
    one = drawn("elbow", 3.0, 23.0, 100.0, "test")
    other = drawn("shoulder", 3.0, 23.0, 100.0, "test", seed=5)
    dataclasses.replace(cases.explained(), trajectories=(other, one)).save(tmp_path)
    with open_page(tmp_path / "report.html", width=1400) as page:
        page.wait_for("document.querySelectorAll('#motion .main-svg').length > 0")
        assert page.tab.locator("#joint").input_value() == "elbow", "the joint with the largest share stands first"
        window = "document.getElementById('motion').layout.xaxis.range"
        assert page.tab.evaluate(window) == pytest.approx([3.0, 5.0], abs=1e-3)
        page.tab.locator("#place").fill("1000")
        assert page.tab.evaluate(window) == pytest.approx([20.99, 22.99], abs=1e-2)
        page.tab.locator("#length").select_option("all")
        assert page.tab.evaluate(window) == pytest.approx([3.0, 22.99], abs=1e-3)
        assert page.tab.locator("#place").is_disabled()
        page.tab.locator("#joint").select_option("shoulder")
        name = "[...document.getElementById('motion').data].filter(each => each.name == '{}').map(each => each.y)"
        page.wait_for("document.getElementById('motion').layout.yaxis.range[1] > 0")
        measured, torque = page.tab.evaluate(name.format("measured"))
        position, error, *_ = page.tab.evaluate(name.format("corrected"))
    assert other.position is not None
    assert np.array(measured) == pytest.approx(other.position.measured, abs=2e-4)
    assert np.array(torque) == pytest.approx(other.torque.measured, abs=5e-3)
    told = np.array(error, dtype=float)
    assert told == pytest.approx(other.position.errors[2], abs=1e-6, nan_ok=True)
    assert np.array(position, dtype=float) == pytest.approx(np.array(measured) + told, abs=1e-9, nan_ok=True)


def test_long_recordings_are_thinned() -> None:
    """As many points as six joints may have, however long it was."""
    long = drawn("elbow", 0.0, 600.0, 1000.0, "fit")
    (figure,) = motion_figures(dataclasses.replace(cases.no_discrepancy(), trajectories=(long,)))
    assert max(len(column["steps"]) for column in figure["columns"]) < 1.3 * MOST_TRAJECTORY_POINTS
