"""A budget of evaluations: what takes too long fails by its work, not by the clock, so that load changes no answer."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import pytest

from flexdyn import _core
from flexdyn.diagnose.shooting import shooter as shooting
from flexdyn.diagnose.shooting.gap import shoot
from flexdyn.diagnose.shooting.windows import Windows
from flexdyn.effects import SensorGain
from flexdyn.simulation.inputs_and_signals import SIGNALS
from flexdyn.simulation.plant import build_plant
from flexdyn.simulation.solver_choice import core_settings
from flexdyn.simulation.solvers import DormandPrince, Rosenbrock, RungeKutta4, Solver, TimeStepping
from tests.arms import two_link
from tests.diagnose.truths import ARM, Levels, two_link_recording

SOLVERS = [DormandPrince(), Rosenbrock(), RungeKutta4(step=1e-3), TimeStepping(step=1e-3)]


def _fallen(solver: Solver, most: int) -> tuple[Mapping[str, Any], np.ndarray]:
    """Report and positions of the two-link arm, let go, over half a second."""
    plant, t = build_plant(two_link(ARM)), np.linspace(0.0, 0.5, 51)
    arrays = [np.full((len(t), 2), np.nan) for _ in range(len(SIGNALS))] + [np.empty((len(t), 0))]
    x0 = np.array([0.3, 0.9, 0.3, 0.9, 0.0, 0.0, 0.0, 0.0])
    job = _core.job(plant, _core.open_loop(None), [], x0, 0.5, core_settings(solver, most), t, arrays, None)
    return _core.simulate(job, None), arrays[0]


@pytest.mark.parametrize("solver", SOLVERS, ids=lambda solver: type(solver).__name__)
def test_a_run_fails_when_its_budget_is_spent(solver: Solver) -> None:
    """One that is too small by one evaluation and one that is just enough, which changes nothing; 0 is no limit."""
    free, q = _fallen(solver, 0)
    assert not free["reason"]
    enough, same = _fallen(solver, free["evaluations"])
    assert not enough["reason"]
    np.testing.assert_array_equal(same, q)
    short, begun = _fallen(solver, free["evaluations"] // 3)
    assert short["reason"] == "more evaluations than allowed"
    assert 0.0 < short["t"] < 0.5
    assert 0 < short["written"] < len(q)
    np.testing.assert_array_equal(begun[: short["written"]], q[: short["written"]])


def test_windows_that_take_more_have_failed(monkeypatch: pytest.MonkeyPatch) -> None:
    """All of them under a tiny budget, none under the usual one."""
    model = two_link(ARM)
    windows = Windows.of(model, [two_link_recording(Levels(), 0)], Levels().noise())
    assert not shoot(model, windows).failed.any()
    monkeypatch.setattr(shooting, "MOST_EVALUATIONS", 50)
    assert shoot(model, windows).failed.all()


def test_windows_that_failed_are_whitened_all_the_same(monkeypatch: pytest.MonkeyPatch) -> None:
    """Behind an encoder with a gain: where a simulation ended, there is no position for its slope."""
    model = two_link(ARM)
    windows = Windows.of(model, [two_link_recording(Levels(), 0)], Levels().noise())
    monkeypatch.setattr(shooting, "MOST_EVALUATIONS", 50)
    shot = shoot(model.replace(effects=[SensorGain("q.shoulder", gain=0.01)]), windows)
    assert shot.failed.all()
    assert np.isfinite(shot.whitened()).all()
    assert np.isfinite(shot.log_likelihood)
