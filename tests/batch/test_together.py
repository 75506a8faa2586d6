"""Runs that differ in numbers alone are integrated and measured at once, and are what each is by itself."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import flexdyn as fd
from flexdyn.batch.aim import aim_of
from flexdyn.batch.cases import Cases
from flexdyn.batch.catalogue import METRICS
from flexdyn.batch.draws import draws_of_runs
from flexdyn.batch.metrics import metrics_of, metrics_of_runs
from flexdyn.batch.motion import RunsMotion
from flexdyn.batch.studyfile import read_study
from flexdyn.simulation.inputs_and_signals import SIGNALS
from tests.arms import EXACT
from tests.batch.studies import write_study

VARY: dict[str, Any] = {
    "initial.q.elbow": {"uniform": [-1.0, 1.0]},
    "initial.v.*": {"normal": [0.0, 0.5]},
    "initial.theta.shoulder": {"uniform": [-0.1, 0.1]},
    "joints.*.stiffness": {"uniform": [20, 60]},
    "joints.elbow.damping": {"uniform": [0.01, 0.2]},
    "joints.elbow.gear_ratio": {"uniform": [80, 120]},
    "joints.shoulder.rotor_inertia": {"lognormal": [1e-5, 0.1]},
    "effects[0].coefficient": {"uniform": [0.01, 0.03]},
    "effects[1].level": {"normal": [0.05, 0.01]},
}
SOLVERS: list[Any] = [{"name": "DormandPrince", "rtol": 1e-4, "atol": 1e-5}, {"name": "TimeStepping", "step": 1e-3}]


def at_once(path: Path) -> tuple[Cases, dict[str, Any], dict[str, Any], Any]:
    """A study's cases, its numbers, the signals of its runs, and which of them were done together."""
    cases = Cases(read_study(path))
    numbers = draws_of_runs(cases.study, range(cases.study.count))
    signals = {signal: np.full((cases.study.count, len(cases.times), 2), np.nan) for signal in SIGNALS}
    return cases, numbers, signals, cases.together(numbers, signals, None)


@pytest.mark.parametrize("solver", SOLVERS, ids=lambda solver: solver["name"])
@pytest.mark.parametrize("command", ["torque.csv", "start.csv", {"pd": {"reference": "path.csv", "kp": 20, "kd": 1}}])
def test_together_as_alone(tmp_path: Path, solver: Any, command: Any) -> None:
    """First states over and under those of a recording, drives and laws: every signal bit for bit that of simulate."""
    start = {"tau.shoulder": [0.1, 0.1], "tau.elbow": [0.1, 0.1], "q.elbow": [0.3, 0.3], "omega.shoulder": [0.2, 0.2]}
    path = write_study(tmp_path, vary=VARY, solver=solver, runs=12)
    fd.write_recording(fd.Recording([0.0, 0.1], start), tmp_path / "start.csv")
    path = write_study(tmp_path, vary=VARY, solver=solver, command=command, runs=12)
    cases, _, signals, done = at_once(path)
    assert done.all()
    for k in range(12):
        case = cases.case(k)
        run = fd.simulate(case.model, case.command, 0.2, cases.solver, rate=100, **case.starts)
        for signal, column in signals.items():
            np.testing.assert_array_equal(column[k], getattr(run, signal))


def test_numbers_that_are_refused_or_neutral_stand_alone(tmp_path: Path) -> None:
    """A law that a number switches off, a spring or friction below zero: such runs are left to be done one by one."""
    grid = {"effects[1].level": {"grid": [0.05, 0.0]}, "joints.elbow.stiffness": {"grid": [30.0, 40.0]}}
    out, path = tmp_path / "out.zarr", write_study(tmp_path, vary=grid, runs=None)
    cases, _, _, done = at_once(path)
    assert done.tolist() == [True, True, False, False]
    data = fd.run_study(path, out).dataset()
    assert (data.status == "ok").all()
    for k in range(4):
        case = cases.case(k)
        np.testing.assert_array_equal(data.q[k], fd.simulate(case.model, case.command, 0.2, cases.solver, rate=100).q)
    wild = {"effects[1].level": {"normal": [0.01, 0.02]}, "joints.elbow.stiffness": {"normal": [10.0, 10.0]}}
    path = write_study(tmp_path, vary=wild, runs=40)
    _, numbers, _, done = at_once(path)
    good = np.logical_and.reduce([column > 0.0 for column in numbers.values()])
    assert 0 < good.sum() < 40
    assert (done == good).all()


@pytest.mark.parametrize(
    "changes",
    [
        {"vary": {"robot.gravity[1]": {"uniform": [-1.0, 1.0]}}},
        {"vary": {"effects[2].mass": {"uniform": [0.1, 0.5]}}},
        {"vary": {"command.scale": {"uniform": [0.1, 0.5]}}},
        {"solver": "auto"},
        {"metrics": ["energy_supplied"]},
    ],
    ids=str,
)
def test_what_changes_more_than_numbers_stands_alone(tmp_path: Path, changes: Any) -> None:
    """Other links, another command, a solver chosen run by run, a metric that needs whole runs: one by one."""
    assert not at_once(write_study(tmp_path, **changes))[3].any()


def test_measured_together_as_alone() -> None:
    """Every metric of the catalogue over five runs at once, and over each: the same to the last bit, reasons too."""
    model = fd.load_model("scara_two_link")
    t = np.linspace(0.0, 0.5, 51)
    reference = fd.Samples(t, np.column_stack([np.sin(t), np.cos(t)]), "cubic")
    command = fd.PD(reference, kp=10.0, kd=1.0)
    rng = np.random.default_rng(4)
    runs = [fd.simulate(model, command, 1.0, EXACT, q0=rng.uniform(-1.0, 1.0, 2), rate=200) for _ in range(5)]
    aim = aim_of(command, model, 1.0)
    found = metrics_of(list(METRICS), model, aim)
    signals = {signal: np.array([getattr(run, signal) for run in runs]) for signal in SIGNALS}
    values, reasons = metrics_of_runs(found, RunsMotion(model.robot, runs[0].t, signals, aim, runs))
    assert np.isfinite(values).any(axis=1).sum() >= len(found) - 1
    for i, run in enumerate(runs):
        alone, reason = metrics_of_runs(found, RunsMotion.of(run, aim))
        np.testing.assert_array_equal(values[:, i], alone[:, 0])
        assert reasons[i] == reason[0]
