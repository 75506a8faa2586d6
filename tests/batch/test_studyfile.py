"""Study files: what they mean, and that every mistake is one line with file, key and remedy before anything runs."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

import flexdyn as fd
from flexdyn.batch.study import Study
from flexdyn.batch.studyfile import read_study, study_from_dict
from flexdyn.errors import InputError
from flexdyn.io.yaml import dump_yaml
from tests.batch.studies import ARM, STUDY, write_study

PD: dict[str, Any] = {"reference": "path.csv", "kp": 20.0, "kd": 0.4}
RIGID = ARM | {"joints": {}, "effects": []}


def vary(path: str, **law: Any) -> dict[str, Any]:
    """A study in which one number varies."""
    return {"vary": {path: law}}


MISTAKES: list[tuple[dict[str, Any], list[str]]] = [
    ({"durration": 1.0}, ["durration", "no such key", "did you mean 'duration'?"]),
    ({"flexdyn_study": 2}, ["flexdyn_study", "no such format", "got 2", "format 1"]),
    ({"model": "amr.yaml"}, ["amr.yaml", "no such file"]),
    ({"model": 3}, ["model", "path of a model file", "got 3"]),
    ({"model": "scra"}, ["'scara'"]),
    ({"command": "torque.cvs"}, ["command", "no such file", "'torque.cvs'", "looked for in"]),
    ({"command": 1.0}, ["command", "recording, or a mapping with pd:"]),
    ({"command": {"dp": {}}}, ["command.dp", "known: pd"]),
    ({"command": {"pd": PD | {"kpp": 1}}}, ["command.pd.kpp", "did you mean 'kp'?"]),
    ({"command": {"pd": PD | {"kp": [1, 2, 3]}}}, ["command.pd.kp", "2 joints"]),
    ({"command": {"pd": PD | {"reference": "no.csv"}}}, ["command.pd.reference", "no such file", "'no.csv'"]),
    ({"command": {"pd": PD | {"rate": 0}}}, ["command.pd.rate", "above 0 Hz"]),
    ({"duration": -1}, ["duration", "above 0 s", "got -1"]),
    ({"duration": None, "command": None}, ["duration", "is missing"]),
    ({"rate": "fast"}, ["rate", "above 0 Hz", "'fast'"]),
    ({"rate": 1e12}, ["rate", "samples in a run"]),
    ({"solver": "TimeSteping"}, ["solver", "did you mean 'TimeStepping'?"]),
    ({"solver": {"name": "TimeStepping", "stp": 1e-3}}, ["solver.stp", "takes step"]),
    ({"solver": {"step": 1e-3}}, ["solver", "name is needed"]),
    ({"solver": {"name": "RungeKutta4", "step": 1e-3}}, ["smoothing"]),
    ({"runs": None}, ["runs", "missing", "runs: 400"]),
    ({"runs": 2.5}, ["runs", "whole number", "got 2.5"]),
    ({"runs": 10**10}, ["runs", "more than 100000000"]),
    ({"vary": {"command.scale": {"grid": [1, 2]}}}, ["runs", "got 12", "2 points"]),
    ({"seed": -1}, ["seed", "at least 0"]),
    ({"seed": "a"}, ["seed", "'a'"]),
    ({"vary": {}}, ["vary", "mapping of what varies"]),
    (vary("joints.sholder.stiffness", uniform=[1, 2]), ["vary.joints.sholder.stiffness", "'joints.shoulder."]),
    (vary("joints.elbow.stifness", uniform=[1, 2]), ["did you mean 'joints.elbow.stiffness'?"]),
    (vary("effects[0].level", uniform=[1, 2]), ["vary.effects[0].level", "mean 'effects[0].coefficient'?"]),
    (vary("effects[9].level", uniform=[1, 2]), ["vary.effects[9].level", "no such number"]),
    ({"vary": {"command.scale": {"uniform": [1]}}}, ["vary.command.scale.uniform", "two numbers", "[lowest, highest]"]),
    ({"vary": {"command.scale": {"uniform": [2, 1]}}}, ["vary.command.scale.uniform", "lower one"]),
    ({"vary": {"command.scale": {"normal": [2, 0]}}}, ["vary.command.scale.normal", "above 0"]),
    ({"vary": {"command.scale": {"lognormal": [-2, 0.1]}}}, ["vary.command.scale.lognormal", "median"]),
    ({"vary": {"command.scale": {"normal": [math.nan, 1]}}}, ["vary.command.scale.normal", "finite"]),
    ({"vary": {"command.scale": {"normall": [1, 1]}}}, ["vary.command.scale.normall", "did you mean 'normal'?"]),
    ({"vary": {"command.scale": 2}}, ["vary.command.scale", "one distribution"]),
    ({"vary": {"command.scale": {"grid": []}}, "runs": None}, ["vary.command.scale.grid", "list of numbers"]),
    ({"vary": {"command.scale": {"grid": [1, 2, 1]}}, "runs": None}, ["grid[2]", "twice"]),
    ({"vary": {"joints.elbow.stiffness": {"uniform": [-5, 50]}}}, ["vary.joints.elbow.stiffness", "-5", "above 0"]),
    ({"vary": {"initial.theta.elbow": {"uniform": [0, 1]}}, "model": RIGID}, ["vary.initial.theta.elbow", "rigid"]),
    ({"keep": ["q", "tetha"]}, ["keep[1]", "did you mean 'theta'?"]),
    ({"keep": "q"}, ["keep", "list of names"]),
    ({"keep": ["q", "q"]}, ["keep[1]", "twice"]),
    ({"keep": [], "metrics": []}, ["keep", "nothing of the runs would be stored"]),
    ({"metrics": ["tip_deflection"]}, ["metrics[0]", "did you mean 'tip_deflection_"]),
    ({"metrics": ["no_such_module:f"]}, ["metrics[0]", "no_such_module"]),
    ({"chunk": 0}, ["chunk", "at least 1"]),
]


@pytest.mark.parametrize(("changes", "words"), MISTAKES, ids=lambda value: str(value)[:60])
def test_mistakes(tmp_path: Path, changes: dict[str, Any], words: list[str]) -> None:
    """One line that starts with a file and names key, value and remedy."""
    path = write_study(tmp_path, **changes)
    with pytest.raises(InputError) as caught:
        read_study(path)
    line = str(caught.value)
    assert line.startswith(str(tmp_path)) or "scra" in line
    assert "\n" not in line
    for word in words:
        assert word in line, line


def test_the_study_of_the_contract(tmp_path: Path) -> None:
    """Paths are relative to the study file, wherever one stands, and every default is filled in."""
    path = write_study(tmp_path / "there", rate=None, solver=None, duration=None, seed=None, chunk=None)
    study = read_study(path)
    assert study.command == str((tmp_path / "there" / "torque.csv").resolve())
    assert (study.rate, study.solver, study.seed, study.count) == (1000.0, {"name": "auto"}, 0, 12)
    assert study.duration == pytest.approx(0.2)  # of the command
    assert study.model["joints"]["elbow"]["stiffness"] == 30.0


def test_a_controller_in_the_study_or_in_a_file_of_its_own(tmp_path: Path) -> None:
    """``command: {pd: ...}`` and ``command: pd.yaml`` are the same study."""
    inside = read_study(write_study(tmp_path, command={"pd": PD}, vary={"command.pd.kp": {"uniform": [10, 30]}}))
    (tmp_path / "pd.yaml").write_text(dump_yaml({"pd": PD}))
    other = read_study(write_study(tmp_path, command="pd.yaml", vary={"command.pd.kp": {"uniform": [10, 30]}}))
    assert inside == other
    assert inside.command["pd"]["reference"] == str((tmp_path / "path.csv").resolve())


def test_a_shipped_model_and_a_model_in_the_study(tmp_path: Path) -> None:
    """``model`` is a path, the name of a shipped model, or what a model file holds."""
    vary = {"joints.elbow.stiffness": {"uniform": [5, 6]}}
    assert read_study(write_study(tmp_path, model="scara_two_link", vary=vary)).name == "scara_two_link"
    inside = read_study(write_study(tmp_path, model=ARM))
    assert inside.difference(read_study(write_study(tmp_path))) is None


def test_plain_data_there_and_back(tmp_path: Path) -> None:
    """A study survives as text to the last bit, infinite stiffness included."""
    study = read_study(write_study(tmp_path, model=RIGID, vary={"command.scale": {"uniform": [0.1, 1 / 3]}}))
    assert study.model["joints"]["elbow"]["stiffness"] == math.inf
    assert Study.from_text(study.to_text()) == study


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"seed": 8}, "seed is 7 here and 8 there"),
        ({"runs": 13}, "runs is 12 here and 13 there"),
        ({"vary": STUDY["vary"] | vary("command.scale", uniform=[1, 2])["vary"]}, "vary.command.scale.uniform is not"),
        ({"solver": {"name": "TimeStepping", "step": 2e-3}}, "solver.step is 0.001 here and 0.002 there"),
        ({"keep": ["q"]}, "keep is ['q', 'theta'] here and ['q'] there"),
    ],
)
def test_the_difference_of_studies(tmp_path: Path, changes: dict[str, Any], words: str) -> None:
    """It names the first key that makes other numbers, with both values."""
    mine, other = read_study(write_study(tmp_path)), read_study(write_study(tmp_path, **changes))
    assert words in str(mine.difference(other))


def test_files_are_compared_by_what_they_hold(tmp_path: Path) -> None:
    """A study that was moved is the same; one whose command was written anew is not."""
    here, there = read_study(write_study(tmp_path / "a")), read_study(write_study(tmp_path / "b"))
    assert here.difference(there) is None
    recording = fd.read_recording(tmp_path / "b" / "torque.csv")
    changed = {name: 1.01 * column for name, column in recording.channels.items()}
    fd.write_recording(fd.Recording(recording.t, changed), tmp_path / "b" / "torque.csv")
    again = study_from_dict(STUDY, tmp_path / "b")
    assert here.difference(again) == "what the file of command holds has changed"


def test_chunks_follow_from_the_study_alone(tmp_path: Path) -> None:
    """Few runs are cut into 64 chunks, many into chunks of 256, and long ones into smaller ones, to 16 MB."""

    def chunk(**changes: Any) -> int:
        return read_study(write_study(tmp_path, chunk=None, **changes)).chunk

    assert chunk(runs=640) == 10
    assert chunk(runs=10**6) == 256
    long = chunk(runs=10**6, duration=200.0, rate=100)
    assert 16e6 / 2 < long * 20_000 * 8 * 15 <= 16e6
    assert chunk(runs=10, duration=10_000.0) == 1
    assert read_study(write_study(tmp_path, chunk=500)).chunk == 12


def test_the_runs_of_all_chunks_are_all_runs(tmp_path: Path) -> None:
    """None is missing, none is there twice, the last chunk may be short."""
    study = replace(read_study(write_study(tmp_path)), runs=13, chunk=5)
    assert [k for chunk in range(study.chunks) for k in study.bounds(chunk)] == list(range(13))


ODD: list[Any] = [None, True, -1, 0, math.inf, math.nan, "", "a\nb", "x" * 10_000, [], [None], [[]], {}, {"": None}]
ODD += [{"a": {"b": []}}, 10**400]


def with_odd(key: str, odd: Any) -> dict[str, Any]:
    """A study with an odd value at a key, or at one inside of it."""
    outer, _, inner = key.partition(".")
    beside = STUDY[outer] if isinstance(STUDY.get(outer), dict) else {}
    return STUDY | {outer: {**beside, inner: odd} if inner else odd}


@pytest.mark.parametrize("key", [*STUDY, "vary.x", "vary.command.scale", "solver.name", "solver.step", "command.pd"])
def test_odd_values_are_mistakes_too(tmp_path: Path, key: str) -> None:
    """Whatever stands at a key, the study is read, or refused in one line of bounded length; never a traceback."""
    write_study(tmp_path)
    refused = []
    for odd in ODD:
        try:
            study_from_dict(with_odd(key, odd), tmp_path)
        except InputError as error:
            refused.append(str(error))
    assert refused
    assert all("\n" not in line and len(line) < 3000 for line in refused)
