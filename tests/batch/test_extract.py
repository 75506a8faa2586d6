"""One run taken out of a study: the line that is printed makes that very run, to the last bit."""

from __future__ import annotations

import shlex
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import flexdyn as fd
from flexdyn.batch.results import Results
from flexdyn.batch.run_study import run_study
from flexdyn.cli import main
from tests.batch.small import pulse_study


def same_bits(results: Results, k: int, folder: Path) -> bool:
    """Take a run out, have its line done by the command line, and hold every stored channel against it."""
    line = results.extract(k, folder).line
    words = shlex.split(line)
    assert words[:2] == ["flexdyn", "simulate"]
    assert main(words[1:]) == 0
    made = fd.read_recording(words[-1])
    stored = results.dataset().sel(run=k)
    return all(
        np.array_equal(stored[channel].sel(joint=joint).values, made[f"{channel}.{joint}"])
        for channel in results.channels
        for joint in results.joints
    )


def scara(folder: Path, **changes: Any) -> dict[str, Any]:
    """A study of the paper's arm under logged torques."""
    t = np.linspace(0.0, 0.3, 31)
    torques = {"tau.shoulder": 0.5 * np.sin(20.0 * t), "tau.elbow": 0.3 * np.where(t < 0.15, 1.0, -1.0)}
    fd.write_recording(fd.Recording(t, torques), folder / "log.csv")
    study = {
        "flexdyn_study": 1,
        "model": "scara_two_link",
        "command": str(folder / "log.csv"),
        "duration": 0.5,
        "rate": 200,
        "solver": {"name": "TimeStepping", "step": 1e-3},
        "runs": 5,
        "seed": 11,
        "vary": {
            "joints.shoulder.stiffness": {"uniform": [3.0, 9.0]},
            "effects[4].level": {"normal": [0.02, 0.003]},
            "initial.q.elbow": {"uniform": [0.5, 1.5]},
            "command.scale": {"uniform": [0.8, 1.2]},
        },
        "keep": ["q", "theta", "tau_applied"],
        "metrics": [],
    }
    return study | changes


def test_a_run_under_a_log(tmp_path: Path) -> None:
    """Stiffness, friction, first position and the command's scale are all in the files."""
    results = run_study(scara(tmp_path), tmp_path / "out.zarr")
    taken = results.extract(3, tmp_path / "three")
    assert taken.values == {path: values[3] for path, values in results.parameters.items()}
    model = fd.load_model(taken.model)
    assert model.joints["shoulder"].stiffness == taken.values["joints.shoulder.stiffness"]
    assert taken.command is not None
    scaled, log = fd.read_recording(taken.command), fd.read_recording(tmp_path / "log.csv")
    np.testing.assert_array_equal(scaled["tau.elbow"], taken.values["command.scale"] * log["tau.elbow"])
    assert same_bits(results, 3, tmp_path / "three")
    made = fd.read_recording(tmp_path / "three" / "run.npz")
    assert not np.array_equal(results.dataset()["q"].sel(run=2, joint="elbow").values, made["q.elbow"])


def test_a_first_position_over_that_of_a_recording(tmp_path: Path) -> None:
    """Where the log has measured a first position and the study draws another, the line says so."""
    t = np.linspace(0.0, 0.3, 31)
    log = {"tau.shoulder": np.sin(20.0 * t), "tau.elbow": 0.0 * t, "q.shoulder": 0.1 + t, "q.elbow": 0.2 + 0.0 * t}
    study = scara(tmp_path, runs=2)
    fd.write_recording(fd.Recording(t, log), tmp_path / "log.csv")
    results = run_study(study, tmp_path / "out.zarr")
    taken = results.extract(1, tmp_path / "one")
    assert f"--q0 elbow={taken.values['initial.q.elbow']!r}" in taken.line
    assert same_bits(results, 1, tmp_path / "one")


def test_a_run_of_a_controller(tmp_path: Path) -> None:
    """Gains that were drawn stand in the command file, its reference lies beside it."""
    t = np.linspace(0.0, 0.3, 31)
    reference = {"q.shoulder": 0.5 * t**2, "q.elbow": 1.0 - t}
    study = scara(
        tmp_path,
        command={"pd": {"reference": str(tmp_path / "path.csv"), "kp": {"shoulder": 9.0, "elbow": 5}, "kd": 0.4}},
        vary={"command.pd.kp.elbow": {"uniform": [3.0, 8.0]}, "command.pd.kd": {"uniform": [0.2, 0.6]}},
        solver={"name": "auto"},
    )
    fd.write_recording(fd.Recording(t, reference), tmp_path / "path.csv")
    results = run_study(study, tmp_path / "out.zarr")
    assert same_bits(results, 4, tmp_path / "four")
    text = (tmp_path / "four" / "command.yaml").read_text(encoding="utf-8")
    assert f"elbow: {float(results.parameters['command.pd.kp.elbow'][4])!r}}}" in text


def test_a_run_without_a_command(tmp_path: Path) -> None:
    """No torque: there is no command file."""
    study = pulse_study(tmp_path, command=None, runs=2, metrics=[])
    study["vary"] = {"initial.q.lift": {"uniform": [0.0, 1.0]}, "initial.theta.lift": {"uniform": [0.0, 1.0]}}
    results = run_study(study, tmp_path / "out.zarr")
    assert results.extract(1, tmp_path / "one").command is None
    assert same_bits(results, 1, tmp_path / "one")


@pytest.mark.parametrize("k", [-1, 5, True, "2"])
def test_there_is_no_such_run(tmp_path: Path, k: Any) -> None:
    """A number beyond the study's runs is refused, and nothing is written."""
    results = run_study(scara(tmp_path, duration=0.01), tmp_path / "out.zarr")
    with pytest.raises(fd.InputError, match=r"extract: there is no such run, got .*; runs are 0 to 4"):
        results.extract(k, tmp_path / "x")
    assert not (tmp_path / "x").exists()


def test_a_setting_that_the_command_line_lacks(tmp_path: Path) -> None:
    """What flexdyn simulate cannot be told is said, rather than another run made."""
    solver = {"name": "DormandPrince", "max_step": 0.01}
    results = run_study(scara(tmp_path, solver=solver, duration=0.01), tmp_path / "out.zarr")
    with pytest.raises(fd.InputError, match=r"solver\.max_step: flexdyn simulate does not take this setting"):
        results.extract(0, tmp_path / "x")
