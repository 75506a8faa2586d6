"""flexdyn batch: run a study, look into its store, take a run out again."""

from __future__ import annotations

import shlex
from pathlib import Path

import numpy as np
import pytest

import flexdyn as fd
from tests.batch.studies import tree, write_study
from tests.cli.conftest import Runner


def test_a_study(flexdyn: Runner, tmp_path: Path) -> None:
    """It runs, says in tables what came out, and nothing on stderr where that is no terminal."""
    write_study(tmp_path)
    outcome = flexdyn("batch", "study.yaml", "-o", "out.zarr")
    assert (outcome.code, outcome.err) == (0, "")
    for words in ("out.zarr: 12 of 12 runs done, 0 of them failed", "tip_deflection_max", "joints.shoulder.stiffness"):
        assert words in outcome.out
    again = flexdyn("batch", "--summary", "out.zarr")
    assert again.out == outcome.out


def test_json(flexdyn: Runner, tmp_path: Path) -> None:
    """The summary as data, the same from the run and from the store."""
    write_study(tmp_path)
    run = flexdyn("batch", "study.yaml", "-o", "out.zarr", "--workers", "1", "--json").json
    assert (run["runs"], run["done"], run["failed"]) == (12, 12, 0)
    assert [metric["name"] for metric in run["metrics"]] == ["tip_deflection_max"]
    assert flexdyn("batch", "out.zarr", "--summary", "--json").json == run


def test_resume(flexdyn: Runner, tmp_path: Path) -> None:
    """Without --resume the store is refused; with it nothing is left to do, and nothing changes."""
    write_study(tmp_path)
    flexdyn("batch", "study.yaml", "-o", "out.zarr")
    before = tree(tmp_path / "out.zarr")
    refused = flexdyn("batch", "study.yaml", "-o", "out.zarr")
    assert refused.code == 2
    assert refused.err.startswith("flexdyn: out.zarr: it exists already; continue it with --resume")
    assert flexdyn("batch", "study.yaml", "-o", "out.zarr", "--resume").code == 0
    assert tree(tmp_path / "out.zarr") == before


def test_runs_that_fail_are_no_failure(flexdyn: Runner, tmp_path: Path) -> None:
    """Exit 0, and a table of reasons."""
    write_study(tmp_path, vary={"effects[1].level": {"normal": [0.005, 0.01]}})
    outcome = flexdyn("batch", "study.yaml", "-o", "out.zarr")
    assert outcome.code == 0
    assert "What failed" in outcome.out
    assert "coulomb_friction.level" in outcome.out


def test_a_run_taken_out(flexdyn: Runner, tmp_path: Path) -> None:
    """The line that --extract prints makes that very run, to the last bit."""
    write_study(tmp_path)
    results = fd.run_study(tmp_path / "study.yaml", tmp_path / "out.zarr")
    outcome = flexdyn("batch", "--extract", "5", "out.zarr", "-o", "run5")
    assert outcome.code == 0
    line = outcome.out.strip().splitlines()[-1]
    words = shlex.split(line)
    assert words[:2] == ["flexdyn", "simulate"]
    assert flexdyn(*words[1:]).code == 0
    run = fd.read_recording(words[words.index("-o") + 1])
    np.testing.assert_array_equal(run.signal("q", ["shoulder", "elbow"]), results.dataset().q[5])
    data = flexdyn("batch", "--extract", "5", "out.zarr", "-o", "run5", "--json").json
    assert data["line"] == line


def test_a_picture(flexdyn: Runner, tmp_path: Path) -> None:
    """--summary with --output draws."""
    write_study(tmp_path)
    fd.run_study(tmp_path / "study.yaml", tmp_path / "out.zarr")
    outcome = flexdyn("batch", "--summary", "out.zarr", "-o", "study.html", "--view", "metrics")
    assert "drawn in study.html" in outcome.out
    assert (tmp_path / "study.html").stat().st_size > 1000


MISTAKES = [
    (["batch"], ["missing argument 'STUDY|OUT'"]),
    (["batch", "study.yaml"], ["--output", "say where to write"]),
    (["batch", "stdy.yaml", "-o", "out.zarr"], ["stdy.yaml", "no such file"]),
    (["batch", "study.yaml", "-o", "out.zarr", "--workers", "0"], ["--workers", "at least 1", "got 0"]),
    (["batch", "study.yaml", "-o", "out.zarr", "--workers", "x"], ["--workers", "integer"]),
    (["batch", "study.yaml", "-o", "no/out.zarr"], ["no/out.zarr", "no such folder"]),
    (["batch", "study.yaml", "-o", "o.zarr", "--workers", "1", "--scheduler", "tcp://127.0.0.1:1"], ["--workers"]),
    (["batch", "there.zarr", "-o", "out.zarr"], ["there.zarr", "it is a folder", "--summary or --extract"]),
    (["batch", "--summary", "no.zarr"], ["no.zarr", "no such store"]),
    (["batch", "--summary", "study.yaml"], ["study.yaml", "not the store of a batch study"]),
    (["batch", "--summary", "there.zarr"], ["there.zarr", "not the store of a batch study"]),
    (["batch", "--extract", "5", "done.zarr"], ["--output", "say where to write"]),
    (["batch", "--extract", "12", "done.zarr", "-o", "x"], ["--extract", "no such run", "0 to 11"]),
    (["batch", "--extract", "5", "done.zarr", "-o", "study.yaml"], ["study.yaml", "it is a file"]),
    (["batch", "--extract", "5", "--summary", "done.zarr"], ["--summary --extract", "one at a time"]),
    (["batch", "--summary", "done.zarr", "-o", "x.png", "--view", "metric"], ["--view", "'metric'", "'metrics'"]),
]


@pytest.mark.parametrize(("arguments", "words"), MISTAKES, ids=lambda value: " ".join(value)[:60])
def test_mistakes(flexdyn: Runner, tmp_path: Path, arguments: list[str], words: list[str]) -> None:
    """One line on stderr, exit 2, and nothing new in the folder."""
    write_study(tmp_path)
    (tmp_path / "there.zarr").mkdir()
    if "done.zarr" in arguments:
        fd.run_study(tmp_path / "study.yaml", tmp_path / "done.zarr")
    before = sorted(tmp_path.iterdir())
    outcome = flexdyn(*arguments)
    assert (outcome.code, outcome.out) == (2, "")
    assert outcome.err.count("\n") == 1
    for word in words:
        assert word in outcome.err, outcome.err
    assert sorted(tmp_path.iterdir()) == before
