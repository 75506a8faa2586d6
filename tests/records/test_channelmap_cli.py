"""``flexdyn simulate --map``: a command out of somebody's log."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import flexdyn as fd
from flexdyn.cli import main

LOG = "time;i1;i2\n" + "".join(f"{k};{k % 3};{-k % 5}\n" for k in range(21))
MAP = """\
flexdyn_map: 1
time: {from: time, unit: ms}
channels:
  tau.shoulder: {from: i1, unit: A, torque_constant: 0.05, side: motor, gear_ratio: 100}
  tau.elbow: {from: i2, unit: A, torque_constant: 0.05, side: motor, gear_ratio: 100}
"""


@pytest.fixture
def files(tmp_path: Path) -> tuple[str, str, str]:
    """A log in amperes, its map, and a run to be written."""
    (tmp_path / "log.csv").write_text(LOG)
    (tmp_path / "map.yaml").write_text(MAP)
    return str(tmp_path / "log.csv"), str(tmp_path / "map.yaml"), str(tmp_path / "run.npz")


def test_a_mapped_command(files: tuple[str, str, str]) -> None:
    """The run holds the torques that the currents make behind the gear."""
    log, path, run = files
    assert main(["simulate", "scara_two_link", "--command", log, "--map", path, "-o", run]) == 0
    rec = fd.read_recording(run)
    assert rec.duration == pytest.approx(0.02)
    np.testing.assert_allclose(rec["tau.shoulder"][:20], [5.0 * (k % 3) for k in range(20)], atol=1e-12)
    np.testing.assert_allclose(rec["tau.elbow"][:20], [5.0 * (-k % 5) for k in range(20)], atol=1e-12)


@pytest.mark.parametrize("command", [None, "pd.yaml"])
def test_a_map_needs_a_recording(
    files: tuple[str, str, str], command: str | None, capsys: pytest.CaptureFixture[str]
) -> None:
    """Without a command, or with a controller as command, there is nothing to map."""
    _, path, run = files
    options = ["--command", command] if command else []
    assert main(["simulate", "scara_two_link", *options, "--map", path, "-o", run]) == 2
    line = f"{path}: --map: there is no recording to map; give one as --command"
    assert capsys.readouterr().err == f"flexdyn: {line}\n"


def test_a_column_that_the_command_lacks(files: tuple[str, str, str], capsys: pytest.CaptureFixture[str]) -> None:
    """The line names the recording, the column, and what there is."""
    log, path, run = files
    Path(path).write_text(MAP.replace("i1", "i3"))
    assert main(["simulate", "scara_two_link", "--command", log, "--map", path, "-o", run]) == 2
    assert capsys.readouterr().err == f"flexdyn: {log}: i3: line 1: no such column; known: time, i1, i2\n"
