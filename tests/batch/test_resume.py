"""Going on with a store: only what is missing or damaged is done, and the end is that of one uninterrupted run."""

from __future__ import annotations

import fcntl
import json
import os
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray

import flexdyn as fd
from flexdyn.batch.progress import Progress
from flexdyn.batch.store import create
from flexdyn.batch.studyfile import read_study
from flexdyn.errors import InputError
from flexdyn.robot.names import find_robot
from tests.batch.studies import pieces, tree, write_study


@pytest.fixture
def whole(tmp_path: Path) -> Path:
    """The store of a study of three chunks, done without interruption."""
    return Path(fd.run_study(write_study(tmp_path), tmp_path / "whole.zarr").path)


def flipped(file: Path) -> None:
    """One bit in the middle of a file turned over."""
    content = bytearray(file.read_bytes())
    content[len(content) // 2] ^= 1
    file.write_bytes(content)


def cut(file: Path) -> None:
    """A file half of which was written."""
    file.write_bytes(file.read_bytes()[: file.stat().st_size // 2])


def emptied(file: Path) -> None:
    """A file that a power failure left without content."""
    file.write_bytes(b"")


@pytest.mark.parametrize("damage", [flipped, cut, emptied, Path.unlink])
@pytest.mark.parametrize("array", ["q", "status", "tip_deflection_max", "effects[1].level"])
def test_a_damaged_piece_is_done_again(whole: Path, damage: Callable[[Path], None], array: str) -> None:
    """Whatever array it belongs to: its chunk of runs, and no other, is done once more."""
    before = tree(whole)
    broken = next(file for file in pieces(whole) if file.parent.name == array and file.name.startswith("c.1"))
    damage(broken)
    seen: list[Progress] = []
    fd.run_study(whole.parent / "study.yaml", whole, resume=True, progress=seen.append)
    assert [progress.done for progress in seen] == [8, 12]
    assert tree(whole) == before


@pytest.mark.parametrize("place", ["q/zarr.json", "time/c.0", "joint/c.0", "run/zarr.json"])
@pytest.mark.parametrize("damage", [flipped, cut, Path.unlink])
def test_damaged_metadata_and_coordinates(whole: Path, damage: Callable[[Path], None], place: str) -> None:
    """They follow from the study and are made good; no run is done again."""
    before = tree(whole)
    damage(whole / place)
    seen: list[Progress] = []
    fd.run_study(whole.parent / "study.yaml", whole, resume=True, progress=seen.append)
    assert [progress.done for progress in seen] == [12]
    assert tree(whole) == before


def test_what_a_kill_leaves_behind_is_removed(whole: Path) -> None:
    """Half-written files beside their places, and half a new store beside the store, are gone after --resume."""
    before = tree(whole)
    (whole / "q" / "c.1.0.0123456789abcdef.partial").write_bytes(b"half")
    left = whole.with_name(f".{whole.name}.part")
    left.mkdir()
    (left / "zarr.json").write_text("{")
    fd.run_study(whole.parent / "study.yaml", whole, resume=True)
    assert tree(whole) == before
    assert not left.exists()


def test_a_store_without_runs_is_readable(tmp_path: Path) -> None:
    """What is not done yet reads as NaN and ``not done``; --resume does it all."""
    path = write_study(tmp_path)
    create(read_study(path), tmp_path / "out.zarr")
    data = xarray.open_zarr(tmp_path / "out.zarr")
    assert (data.status == "not done").all()
    for name in ("q", "tip_deflection_max", "joints.shoulder.stiffness"):
        assert np.isnan(data[name]).all()
    fd.run_study(path, tmp_path / "out.zarr", resume=True)
    fd.run_study(path, tmp_path / "whole.zarr")
    assert tree(tmp_path / "out.zarr") == tree(tmp_path / "whole.zarr")


def test_resume_where_there_is_nothing_yet(tmp_path: Path) -> None:
    """It begins: a job that is restarted by a queue always says --resume."""
    path = write_study(tmp_path)
    assert fd.run_study(path, tmp_path / "out.zarr", resume=True).summary().done == 12


def test_a_store_is_not_written_over(whole: Path) -> None:
    """Without resume what is there stays as it is."""
    before = tree(whole)
    with pytest.raises(InputError, match="it exists already; continue it with --resume"):
        fd.run_study(whole.parent / "study.yaml", whole)
    assert tree(whole) == before


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"seed": 8}, "another study: seed is 8 here and 7 there"),
        ({"duration": 0.3}, r"another study: duration is 0\.3 here and 0\.2 there"),
        ({"metrics": ["tip_deflection_rms"]}, "another study: metrics is .*rms.* here and .*max.* there"),
    ],
)
def test_the_store_of_another_study(whole: Path, changes: dict[str, Any], words: str) -> None:
    """It is refused with the difference named, and stays as it is."""
    before = tree(whole)
    other = write_study(whole.parent, **changes)
    with pytest.raises(InputError, match=words):
        fd.run_study(other, whole, resume=True)
    assert tree(whole) == before


def test_a_urdf_that_was_changed(tmp_path: Path) -> None:
    """The robot's file is part of the study: with another one the store is not gone on with."""
    write_study(tmp_path)
    shutil.copy(find_robot("scara_two_link")[0], tmp_path / "robot.urdf")
    model = fd.load_model("scara_two_link").replace(robot=fd.load_robot(tmp_path / "robot.urdf"))
    fd.save_model(model, tmp_path / "own.yaml")
    path = write_study(tmp_path, model="own.yaml", vary={"joints.shoulder.stiffness": {"uniform": [5, 6]}})
    fd.run_study(path, tmp_path / "out.zarr")
    text = (tmp_path / "robot.urdf").read_text()
    (tmp_path / "robot.urdf").write_text(text + "<!-- heavier -->\n")
    with pytest.raises(InputError, match=r"what the file of model\.robot\.urdf holds has changed"):
        fd.run_study(path, tmp_path / "out.zarr", resume=True)


def test_a_store_of_another_version(whole: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Bit for bit the same cannot be promised of another flexdyn."""
    monkeypatch.setattr(fd, "__version__", "99.0")
    with pytest.raises(InputError, match=r"flexdyn is 99\.0 here and"):
        fd.run_study(whole.parent / "study.yaml", whole, resume=True)


def test_a_store_of_another_format(whole: Path) -> None:
    """One line that says which it is and which is read; nothing in it is touched."""
    file = whole / "zarr.json"
    content = json.loads(file.read_text(encoding="utf-8"))
    content["attributes"]["flexdyn_batch"] += 1
    file.write_text(json.dumps(content), encoding="utf-8")
    before = tree(whole)
    with pytest.raises(InputError, match=r"not the store of a batch study, got 2; this version reads format 1"):
        fd.run_study(whole.parent / "study.yaml", whole, resume=True)
    assert tree(whole) == before


def test_a_study_that_was_moved(whole: Path, tmp_path: Path) -> None:
    """Its folder may be elsewhere when it goes on."""
    shutil.move(whole, tmp_path / "there.zarr")
    moved = write_study(tmp_path / "elsewhere")
    for name in ("study.yaml", "arm.yaml", "torque.csv"):
        (tmp_path / name).unlink()
    pieces(tmp_path / "there.zarr")[0].unlink()
    assert fd.run_study(moved, tmp_path / "there.zarr", resume=True).summary().done == 12


@pytest.mark.parametrize("content", ["a file", "a folder", "a group"])
def test_what_is_no_store(tmp_path: Path, content: str) -> None:
    """Some other file or folder is not taken for a store, and not touched."""
    path, out = write_study(tmp_path), tmp_path / "out.zarr"
    if content == "a file":
        out.write_text("mine")
    else:
        out.mkdir()
        (out / "zarr.json").write_text('{"zarr_format": 3, "node_type": "group"}' if content == "a group" else "mine")
    before = tree(tmp_path)
    with pytest.raises(InputError, match="not the store of a batch study"):
        fd.run_study(path, out, resume=True)
    assert tree(tmp_path) == before


def test_two_at_once(whole: Path) -> None:
    """A store that another process works on is left to it."""
    handle = os.open(whole, os.O_RDONLY)
    fcntl.flock(handle, fcntl.LOCK_EX)
    with pytest.raises(InputError, match="another process is at work"):
        fd.run_study(whole.parent / "study.yaml", whole, resume=True)
    os.close(handle)
    fd.run_study(whole.parent / "study.yaml", whole, resume=True)
