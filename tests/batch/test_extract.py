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
from tests.batch.studies import write_study


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


VARY = {
    "joints.shoulder.stiffness": {"uniform": [20.0, 60.0]},
    "effects[1].level": {"normal": [0.05, 0.01]},
    "initial.q.elbow": {"uniform": [0.5, 1.5]},
    "command.scale": {"uniform": [0.8, 1.2]},
}


def test_a_run_under_a_log(tmp_path: Path) -> None:
    """Stiffness, friction, first position and the command's scale are all in the files."""
    study = write_study(tmp_path, runs=5, vary=VARY, keep=["q", "theta", "tau_applied"])
    results = run_study(study, tmp_path / "out.zarr")
    taken = results.extract(3, tmp_path / "three")
    assert taken.values == {path: values[3] for path, values in results.parameters.items()}
    model = fd.load_model(taken.model)
    assert model.joints["shoulder"].stiffness == taken.values["joints.shoulder.stiffness"]
    assert taken.command is not None
    scaled, log = fd.read_recording(taken.command), fd.read_recording(tmp_path / "torque.csv")
    np.testing.assert_array_equal(scaled["tau.elbow"], taken.values["command.scale"] * log["tau.elbow"])
    assert same_bits(results, 3, tmp_path / "three")
    made = fd.read_recording(tmp_path / "three" / "run.npz")
    assert not np.array_equal(results.dataset()["q"].sel(run=2, joint="elbow").values, made["q.elbow"])


def test_a_first_position_over_that_of_a_recording(tmp_path: Path) -> None:
    """Where the log has measured a first position and the study draws another, the line says so."""
    t = np.linspace(0.0, 0.2, 41)
    log = {"tau.shoulder": np.sin(20.0 * t), "tau.elbow": 0.0 * t, "q.shoulder": 0.1 + t, "q.elbow": 0.2 + 0.0 * t}
    study = write_study(tmp_path, runs=2, vary=VARY)
    fd.write_recording(fd.Recording(t, log), tmp_path / "torque.csv")
    results = run_study(study, tmp_path / "out.zarr")
    taken = results.extract(1, tmp_path / "one")
    assert f"--q0 elbow={taken.values['initial.q.elbow']!r}" in taken.line
    assert same_bits(results, 1, tmp_path / "one")


def test_a_run_of_a_controller(tmp_path: Path) -> None:
    """Gains that were drawn stand in the command file, its reference lies beside it."""
    study = write_study(
        tmp_path,
        runs=5,
        command={"pd": {"reference": "path.csv", "kp": {"shoulder": 9.0, "elbow": 5}, "kd": 0.4}},
        vary={"command.pd.kp.elbow": {"uniform": [3.0, 8.0]}, "command.pd.kd": {"uniform": [0.2, 0.6]}},
        solver={"name": "auto"},
    )
    results = run_study(study, tmp_path / "out.zarr")
    assert same_bits(results, 4, tmp_path / "four")
    text = (tmp_path / "four" / "command.yaml").read_text(encoding="utf-8")
    assert f"elbow: {float(results.parameters['command.pd.kp.elbow'][4])!r}}}" in text


def test_a_run_without_a_command(tmp_path: Path) -> None:
    """No torque: there is no command file."""
    first = {"uniform": [0.0, 1.0]}
    vary = {"initial.q.elbow": first, "initial.theta.elbow": first}
    study = write_study(tmp_path, command=None, runs=2, vary=vary)
    results = run_study(study, tmp_path / "out.zarr")
    assert results.extract(1, tmp_path / "one").command is None
    assert same_bits(results, 1, tmp_path / "one")


@pytest.mark.parametrize("k", [-1, 5, True, "2"])
def test_there_is_no_such_run(tmp_path: Path, k: Any) -> None:
    """A number beyond the study's runs is refused, and nothing is written."""
    results = run_study(write_study(tmp_path, runs=5, duration=0.01), tmp_path / "out.zarr")
    with pytest.raises(fd.InputError, match=r"extract: there is no such run, got .*; runs are 0 to 4"):
        results.extract(k, tmp_path / "x")
    assert not (tmp_path / "x").exists()


def test_a_setting_that_the_command_line_lacks(tmp_path: Path) -> None:
    """What flexdyn simulate cannot be told is said, rather than another run made."""
    solver = {"name": "DormandPrince", "max_step": 0.01}
    results = run_study(write_study(tmp_path, solver=solver, duration=0.01), tmp_path / "out.zarr")
    with pytest.raises(fd.InputError, match=r"solver\.max_step: flexdyn simulate does not take this setting"):
        results.extract(0, tmp_path / "x")
