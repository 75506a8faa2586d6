"""flexdyn plot: files in, a picture or a page out."""

from __future__ import annotations

import math
from pathlib import Path

import pytest

import flexdyn as fd
from tests.cli.conftest import Runner


@pytest.fixture(autouse=True)
def files(tmp_path: Path) -> None:
    """A run, and a measurement of the same joint in degrees."""
    run = fd.simulate(fd.load_model("scara_two_link"), [0.1, 0.0], duration=0.2, rate=200)
    run.save(tmp_path / "run.h5")
    run.save(tmp_path / "run.csv")
    lines = [f"{t!r},{math.degrees(q)!r}" for t, q in zip(run.t.tolist(), run.q[:, 1].tolist(), strict=True)]
    (tmp_path / "log.csv").write_text("\n".join(["time,angle", *lines]), encoding="utf-8")
    (tmp_path / "map.yaml").write_text(
        "flexdyn_map: 1\ntime: {from: time}\nchannels: {q.elbow: {from: angle, unit: deg}}\n", encoding="utf-8"
    )


@pytest.mark.parametrize("suffix", [".png", ".pdf", ".svg", ".html", ".PNG"])
def test_the_suffix_chooses_the_format(flexdyn: Runner, suffix: str) -> None:
    """Each is what its first bytes say; what is left out is said on stdout."""
    outcome = flexdyn("plot", "run.h5", "--view", "positions", "-o", f"out{suffix}")
    assert (outcome.code, outcome.err) == (0, "")
    assert f"drawn in out{suffix}" in outcome.out
    starts = {".png": b"\x89PNG", ".pdf": b"%PDF", ".svg": b"<?xml", ".html": b"<!DOCTYPE html>"}
    assert Path(f"out{suffix}").read_bytes().startswith(starts[suffix.lower()])


def test_the_file_is_the_python_interfaces(flexdyn: Runner) -> None:
    """Views, joints and the window arrive; the picture is that of fd.plot, byte by byte."""
    options = ("--view", "phase", "--view", "torques", "--joint", "elbow", "--from", "0.05", "--to", "0.15")
    assert flexdyn("plot", "run.h5", *options, "-o", "out.svg").code == 0
    fd.plot("run.h5", views=["phase", "torques"], joints="elbow", start=0.05, end=0.15, path="same.svg")
    assert Path("out.svg").read_bytes() == Path("same.svg").read_bytes()


def test_without_a_file_the_browser_is_opened(flexdyn: Runner, monkeypatch: pytest.MonkeyPatch) -> None:
    """An interactive page in a folder for temporary files, whose path is printed."""
    opened: list[str] = []
    monkeypatch.setattr("webbrowser.open", opened.append)
    monkeypatch.setattr("tempfile.tempdir", str(Path.cwd()))
    outcome = flexdyn("plot", "run.h5", "--view", "positions")
    assert outcome.code == 0
    (page,) = opened
    assert page.startswith(Path.cwd().as_uri())
    assert Path(page.removeprefix("file://")).name in outcome.out


def test_the_energy_of_a_file_without_its_model(flexdyn: Runner) -> None:
    """With the model named, a CSV tells what the HDF5 file tells, which holds it."""
    assert flexdyn("plot", "run.h5", "--view", "energy", "-o", "one.svg").code == 0
    assert flexdyn("plot", "run.csv", "--view", "energy", "--model", "scara_two_link", "-o", "two.svg").code == 0
    assert Path("one.svg").read_bytes() == Path("two.svg").read_bytes()


def test_a_measurement_under_a_run_by_its_map(flexdyn: Runner) -> None:
    """The map belongs to the first file; the same angles in degrees leave no residual."""
    outcome = flexdyn("plot", "log.csv", "run.h5", "--map", "map.yaml", "--view", "positions", "-o", "both.svg")
    assert (outcome.code, outcome.err) == (0, "")
    assert "log: recorded, 41 samples" in outcome.out
    rms = float(Path("both.svg").read_text(encoding="utf-8").split("RMS q ")[1].split()[0].rstrip(","))
    assert rms < 1e-15


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("run.h5", "-o", "out.gif"), "out.gif: --output: unknown suffix of a file to write, got '.gif'"),
        (("nothing.h5", "-o", "out.png"), "nothing.h5: no such file"),
        (
            ("run.h5", "--view", "energies", "-o", "out.png"),
            "--view: no such view, got 'energies'; did you mean 'energy'?",
        ),
        (("run.csv", "--view", "energy", "-o", "out.png"), "no energy of run: the file does not hold its model"),
        (("run.h5", "--joint", "wrist", "-o", "out.png"), "--joint: no such joint, got 'wrist'"),
        (("run.h5", "--from", "1", "-o", "out.png"), "--from, --to: run has 0 samples from 1 to 0.2 s"),
        (("run.h5", "--from", "1", "--to", "0", "-o", "out.png"), "--from, --to: the window is empty, got '1 to 0 s'"),
        (("run.h5", "--from", "soon", "-o", "out.png"), "--from: a number is needed, got 'soon'"),
        (
            ("run.h5", "--map", "map.yaml", "--map", "map.yaml", "-o", "o.png"),
            "--map: there are more maps than recordings",
        ),
        ((), "plot: missing argument 'RUN...'"),
    ],
)
def test_mistakes_are_one_line(flexdyn: Runner, arguments: tuple[str, ...], words: str) -> None:
    """Exit code 2, one line that names option and file, and no picture."""
    outcome = flexdyn("plot", *arguments)
    assert outcome.code == 2
    assert words.lower() in outcome.err.lower()
    assert outcome.err.count("\n") == 1
    assert not list(Path().glob("o*.*g"))
