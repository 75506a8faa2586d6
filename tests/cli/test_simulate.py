"""flexdyn simulate: the same run as the Python interface gives, written in every format."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import flexdyn as fd
from tests.cli.conftest import Runner

SMOOTH = """flexdyn: 1
robot: {urdf: scara_two_link, gravity: [0.0, -9.81, 0.0]}
joints: {"*": {rotor_inertia: 1.0e-5, gear_ratio: 100.0, stiffness: 40.0, damping: 0.2}}
"""
TORQUES = "t,tau.shoulder,tau.elbow,q.elbow\n0,0.1,0.2,0.3\n0.05,0.3,-0.1,0.3\n0.2,0,0,0.3\n"


@pytest.fixture(autouse=True)
def inputs(tmp_path: Path) -> None:
    """An arm without dry friction, and torques for it."""
    (tmp_path / "arm.yaml").write_text(SMOOTH, encoding="utf-8")
    (tmp_path / "tau.csv").write_text(TORQUES, encoding="utf-8")


@pytest.mark.parametrize("suffix", [".csv", ".npz", ".h5", ".NPZ"])
def test_each_format_holds_the_run_of_the_python_interface(flexdyn: Runner, suffix: str) -> None:
    """Bit for bit the channels of fd.simulate, whatever the file's format."""
    path = Path(f"run{suffix}")
    outcome = flexdyn("simulate", "arm.yaml", "--command", "tau.csv", "-o", path)
    assert outcome.code == 0
    assert str(path) in outcome.out
    run = fd.simulate(fd.load_model("arm.yaml"), "tau.csv")
    assert fd.read_recording(path).same_as(run.to_recording())
    assert run.t[-1] == pytest.approx(0.2)
    assert run.q[0].tolist() == [0.0, 0.3]


def test_options_are_the_arguments_of_the_python_interface(flexdyn: Runner) -> None:
    """Duration, rate, solver, step and the first state arrive as they were given."""
    options = ["--duration", "0.5", "--rate", "50", "--solver", "RungeKutta4", "--step", "1e-3"]
    options += ["--q0", "0.1,-0.2", "--v0", "elbow=0.5", "--theta0", "shoulder=0.15", "--omega0", "0.4,0.6"]
    assert flexdyn("simulate", "arm.yaml", *options, "-o", "run.npz").code == 0
    run = fd.simulate(
        fd.load_model("arm.yaml"),
        duration=0.5,
        rate=50.0,
        solver=fd.solvers.RungeKutta4(step=1e-3),
        q0=[0.1, -0.2],
        v0={"elbow": 0.5},
        theta0={"shoulder": 0.15},
        omega0=[0.4, 0.6],
    )
    assert len(run.t) == 26
    assert fd.read_recording("run.npz") == run.to_recording()


def test_equilibrium_starts_at_rest(flexdyn: Runner) -> None:
    """With springs loaded by gravity the links do not accelerate in the first moment: tau_s is the weight."""
    arguments = ("--theta0", "equilibrium", "--q0", "0.3,0.4", "--duration", "0.01", "-o", "run.npz")
    assert flexdyn("simulate", "arm.yaml", *arguments).code == 0
    recording = fd.read_recording("run.npz")
    weight = fd.LinkSide(fd.load_model("arm.yaml")).bias([0.3, 0.4], [0.0, 0.0])
    assert [recording["tau_s.shoulder"][0], recording["tau_s.elbow"][0]] == pytest.approx(weight.tolist(), rel=1e-12)


def test_a_positive_and_a_negative_list_of_positions(flexdyn: Runner) -> None:
    """A value that begins with a minus is a value and no option; an option given twice adds up."""
    arguments = ("--q0", "elbow=-0.5", "--q0", "shoulder=-0.25", "--duration", "0.01", "-o", "run.npz")
    assert flexdyn("simulate", "arm.yaml", *arguments).code == 0
    recording = fd.read_recording("run.npz")
    assert [recording["q.shoulder"][0], recording["q.elbow"][0]] == [-0.25, -0.5]
    assert flexdyn("simulate", "arm.yaml", "--q0", "-0.25,-0.5", *arguments[4:]).code == 0
    assert fd.read_recording("run.npz") == recording


def test_tolerances_without_a_solver_mean_the_adaptive_one(flexdyn: Runner) -> None:
    """Solver auto with --rtol is DormandPrince, says so, and takes fewer steps the looser it is."""
    steps = {}
    for rtol in ("1e-3", "1e-10"):
        arguments = ("--duration", "1", "--q0", "1,1", "--rtol", rtol, "--atol", rtol, "-o", "run.npz", "--json")
        outcome = flexdyn("simulate", "arm.yaml", *arguments)
        assert outcome.json["solver"]["name"] == "DormandPrince"
        assert outcome.json["solver"]["rtol"] == float(rtol)
        assert "DormandPrince" in outcome.err
        steps[rtol] = outcome.json["stats"]["steps"]
    assert steps["1e-3"] < steps["1e-10"]


def test_notes_go_to_stderr_and_the_summary_to_stdout(flexdyn: Runner) -> None:
    """A choice made for the user is told, one line each; JSON stays pure and holds the run's own numbers."""
    outcome = flexdyn("simulate", "scara_two_link", "--command", "tau.csv", "-o", "run.npz", "--json")
    run = fd.simulate(fd.load_model("scara_two_link"), "tau.csv")
    assert run.notes
    assert outcome.err == "".join(f"flexdyn: {note}\n" for note in run.notes)
    found = outcome.json
    assert found["samples"] == len(run.t)
    assert found["stats"] == dict(run.stats)
    assert found["joints"]["elbow"]["q_last"] == run.q[-1, 1]
    assert found["joints"]["shoulder"]["deflection_max"] == np.abs(run.deflection[:, 0]).max()
    text = flexdyn("simulate", "scara_two_link", "--command", "tau.csv", "-o", "run.npz").out
    assert "201 samples" in text
    assert "shoulder" in text


def test_a_missing_library_shows_before_the_work(flexdyn: Runner, monkeypatch: pytest.MonkeyPatch) -> None:
    """HDF5 without h5py: refused before a simulation that would take for ever."""
    monkeypatch.setitem(sys.modules, "h5py", None)
    outcome = flexdyn("simulate", "arm.yaml", "--duration", "1e6", "-o", "run.h5", "--rate", "1")
    assert outcome.code == 2
    assert outcome.err == "flexdyn: h5py is not installed; install it with: pip install 'flexdyn[hdf5]'\n"


def test_a_pd_file_tracks(flexdyn: Runner) -> None:
    """A YAML file with pd: drives the arm as fd.PD does."""
    Path("ref.csv").write_text("t,q.shoulder,q.elbow\n0,0,0\n0.1,0.1,0.2\n0.2,0.1,0.2\n", encoding="utf-8")
    Path("pd.yaml").write_text("pd: {reference: ref.csv, kp: 50, kd: 5, rate: 500}\n", encoding="utf-8")
    assert flexdyn("simulate", "arm.yaml", "--command", "pd.yaml", "-o", "run.npz").code == 0
    run = fd.simulate(fd.load_model("arm.yaml"), fd.PD("ref.csv", kp=50, kd=5, rate=500))
    assert fd.read_recording("run.npz") == run.to_recording()


@pytest.mark.parametrize(
    ("solver", "options", "settings"),
    [
        ("RungeKutta4", ("--step", "2e-3"), {"step": 2e-3}),
        ("TimeStepping", ("--step", "2e-3"), {"step": 2e-3}),
        ("TimeStepping", (), {"step": 1e-3}),
        ("Rosenbrock", ("--rtol", "1e-5", "--atol", "1e-7"), {"rtol": 1e-5, "atol": 1e-7}),
        ("DormandPrince", ("--rtol", "1e-5", "--smoothing", "0.01"), {"rtol": 1e-5, "atol": 1e-10, "smoothing": 0.01}),
    ],
)
def test_every_solver_by_its_name(flexdyn: Runner, solver: str, options: tuple[str, ...], settings: Any) -> None:
    """Settings arrive, and the run is that of the Python interface."""
    outcome = flexdyn("simulate", "arm.yaml", "--command", "tau.csv", "--solver", solver, *options, "-o", "run.npz")
    assert outcome.code == 0
    chosen = fd.solvers.make_solver(solver, **settings)
    run = fd.simulate(fd.load_model("arm.yaml"), "tau.csv", solver=chosen)
    assert fd.read_recording("run.npz") == run.to_recording()
    assert f"{solver}, {run.stats['steps']} steps" in outcome.out
    found = flexdyn("simulate", "arm.yaml", "--solver", solver, *options, "--duration", "0.01", "-o", "r.npz", "--json")
    assert found.json["solver"] == {"name": solver, **settings}


def test_events_are_counted(flexdyn: Runner) -> None:
    """Dry friction that stops a joint is an event, and the summary tells how many there were."""
    arguments = ("simulate", "scara_two_link", "--v0", "0.02,0.02", "--duration", "1", "-o", "run.npz")
    events = flexdyn(*arguments, "--json").json["stats"]["events"]
    assert events > 0
    assert f"{events} events" in flexdyn(*arguments).out


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (
            ("--step", "1e-3"),
            "solver auto takes no step, got 0.001; name one that takes a step: --solver RungeKutta4 or",
        ),
        (("--solver", "Rosenbrock", "--step", "1e-3"), "--step: Rosenbrock has no such setting"),
        (("--solver", "TimeStepping", "--rtol", "1e-3"), "--rtol: TimeStepping has no such setting"),
        (("--solver", "RungeKutta4"), "--step: RungeKutta4 needs a step"),
    ],
)
def test_a_setting_that_a_solver_lacks(flexdyn: Runner, options: tuple[str, ...], words: str) -> None:
    """One line with the option's name, and what would be right."""
    outcome = flexdyn("simulate", "arm.yaml", "--duration", "0.1", *options, "-o", "run.npz")
    assert outcome.code == 2
    assert words in outcome.err
    assert outcome.err.count("\n") == 1
