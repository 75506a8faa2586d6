"""flexdyn compare: a table, JSON and a picture of errors."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import flexdyn as fd
from tests.cli.conftest import Runner


@pytest.fixture(autouse=True)
def files(tmp_path: Path) -> None:
    """A sine, and the same 0.5 higher with one channel more."""
    t = np.linspace(0.0, 1.0, 101)
    wave = np.sin(2.0 * np.pi * t)
    fd.write_recording(fd.Recording(t, {"q.a": wave}), tmp_path / "one.csv")
    fd.write_recording(fd.Recording(t, {"q.a": wave + 0.5, "tau.a": t}), tmp_path / "two.npz")


def test_a_table_of_errors(flexdyn: Runner) -> None:
    """Channel, unit and numbers in a row; what only one has below; exit code 0 though they differ."""
    outcome = flexdyn("compare", "one.csv", "two.npz")
    assert (outcome.code, outcome.err) == (0, "")
    (row,) = [line.split() for line in outcome.out.splitlines() if line.strip().startswith("q.a")]
    assert row[:4] == ["q.a", "rad", "0.5", "0.5"]
    assert row[5] == "0.5"
    assert "two - one, 101 samples of one from 0 to 1 s" in outcome.out
    assert "only in two: tau.a" in outcome.out


def test_json_is_the_comparison(flexdyn: Runner) -> None:
    """Pure JSON, the numbers those of fd.compare, in a window too."""
    for options, window in (((), {}), (("--from", "0.2", "--to", "0.4"), {"start": 0.2, "end": 0.4})):
        found = flexdyn("compare", "one.csv", "two.npz", *options, "--json").json
        expected = fd.compare("one.csv", "two.npz", **window).to_dict()
        assert found["channels"] == expected["channels"]
        assert (found["start"], found["end"], found["samples"]) == (
            expected["start"],
            expected["end"],
            expected["samples"],
        )
        assert found["only_second"] == ["tau.a"]


@pytest.mark.parametrize("suffix", [".png", ".svg", ".html"])
def test_a_picture(flexdyn: Runner, suffix: str) -> None:
    """Written beside the table; said where, but not into JSON."""
    outcome = flexdyn("compare", "one.csv", "two.npz", "-o", f"errors{suffix}")
    assert outcome.code == 0
    assert f"drawn in errors{suffix}" in outcome.out
    assert Path(f"errors{suffix}").stat().st_size > 5000
    assert flexdyn("compare", "one.csv", "two.npz", "-o", f"errors{suffix}", "--json").json["first"] == "one"


def test_a_map_of_the_first(flexdyn: Runner) -> None:
    """Maps are given in the order of the files: here degrees of the first, none of the second."""
    Path("raw.csv").write_text("time,deg\n0,0\n1,180\n", encoding="utf-8")
    Path("map.yaml").write_text(
        "flexdyn_map: 1\ntime: {from: time}\nchannels: {q.a: {from: deg, unit: deg}}\n", encoding="utf-8"
    )
    outcome = flexdyn("compare", "raw.csv", "one.csv", "--map", "map.yaml", "--json")
    assert outcome.code == 0
    assert outcome.json["channels"][0]["largest"] == pytest.approx(np.pi)


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("one.csv", "three.csv"), "three.csv: no such file"),
        (("one.csv", "other.csv"), "one.csv, other.csv: channels: one and other have no channel in common"),
        (("one.csv", "late.csv"), "one.csv, late.csv: t: one has 0 samples in the time to be compared"),
        (("one.csv", "two.npz", "-o", "two.npz"), "two.npz: --output: unknown suffix of a file to write"),
        (("one.csv",), "second"),
    ],
)
def test_mistakes_are_one_line(flexdyn: Runner, arguments: tuple[str, ...], words: str) -> None:
    """Exit code 2 and one line that names the files."""
    Path("other.csv").write_text("t,q.b\n0,0\n1,1\n", encoding="utf-8")
    Path("late.csv").write_text("t,q.a\n10,0\n11,1\n", encoding="utf-8")
    outcome = flexdyn("compare", *arguments)
    assert outcome.code == 2
    assert words in outcome.err.lower()
    assert outcome.err.count("\n") == 1
