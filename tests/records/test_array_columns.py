"""Two-dimensional arrays and folders of datasets, as Python programs write them, through a channel map."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest

import flexdyn as fd
from flexdyn.errors import InputError
from tests.records.mapping import channel_map

T = np.arange(5) / 10
Q = np.arange(15.0).reshape(5, 3)


def npz(folder: Path, **arrays: Any) -> Path:
    """An NPZ file by NumPy's own hand."""
    np.savez_compressed(folder / "log.npz", **arrays)
    return folder / "log.npz"


def hdf5(folder: Path, **arrays: Any) -> Path:
    """An HDF5 file by h5py's own hand; double underscores lead into groups."""
    with h5py.File(folder / "log.h5", "w") as file:
        for name, values in arrays.items():
            file[name.replace("__", "/")] = values
    return folder / "log.h5"


@pytest.mark.parametrize("order", ["C", "F"])
@pytest.mark.parametrize("write", [npz, hdf5])
def test_columns_and_rows(tmp_path: Path, write: Any, order: Any) -> None:
    """``q[:,k]`` is a column and ``q[k,:]`` a row, however the array lies in memory."""
    path = write(tmp_path, time=T, q=np.asarray(Q, order=order), tau=np.asarray(Q.T.astype(np.float32), order=order))
    channels = {"q.a": "q[:,0]", "q.b": {"from": "q[:, 2]", "unit": "deg"}, "tau.a": "tau[1,:]"}
    rec = fd.read_recording(path, map=channel_map(time="time", channels=channels))
    np.testing.assert_array_equal(rec["q.a"], Q[:, 0])
    np.testing.assert_allclose(rec["q.b"], np.deg2rad(Q[:, 2]), rtol=1e-15)
    np.testing.assert_array_equal(rec["tau.a"], Q[:, 1])


def test_datasets_anywhere(tmp_path: Path) -> None:
    """A path leads through groups; names by our convention lead where they always do."""
    path = hdf5(tmp_path, robot__arm__time=T, robot__arm__q=Q, tau__elbow=-T)
    channels = {"q.a": "robot/arm/q[:,1]", "tau.a": "tau.elbow"}
    rec = fd.read_recording(path, map=channel_map(time="robot/arm/time", channels=channels))
    np.testing.assert_array_equal(rec["q.a"], Q[:, 1])
    np.testing.assert_array_equal(rec["tau.a"], -T)


def test_groups_that_hold_themselves_come_to_an_end(tmp_path: Path) -> None:
    """Hard links may make a ring; one that leads elsewhere is not followed."""
    path = hdf5(tmp_path, t=T, a__q=T)
    with h5py.File(path, "r+") as file:
        file["a/again"] = file["a"]
        file["a/again_too"] = file["a"]
        file["away"] = h5py.ExternalLink("other.h5", "/q")
    with pytest.raises(InputError, match="the file has more than 10000 columns"):
        fd.read_recording(path, map=channel_map(channels={"q.a": "a/q"}))


@pytest.mark.parametrize("write", [npz, hdf5])
@pytest.mark.parametrize(
    ("source", "line"),
    [
        ("q", "q: the column has the shape (5, 3); a channel map takes one of its columns as q[:,0]"),
        ("q[:,3]", "q[:,3]: no such row or column; q has the shape (5, 3), and rows and columns count from 0"),
        ("t[:,0]", "t[:,0]: no such row or column; t has the shape (5,)"),
        ("q[1,2]", "q[1,2]: neither a row nor a column; take a column as q[:,0] or a row as q[0,:]"),
        ("qq[:,0]", "qq[:,0]: no such column; did you mean 'q'?"),
        (1, "1: no such column; known: "),
        ("text", "text: the column holds "),
    ],
)
def test_columns_that_are_not_there(tmp_path: Path, write: Any, source: str | int, line: str) -> None:
    """The line says what the array looks like."""
    path = write(tmp_path, t=T, q=Q, text=np.array([b"a"] * 5))
    with pytest.raises(InputError, match=re.escape(f"{path}: {line}")):
        fd.read_recording(path, map=channel_map(channels={"q.a": source}))


def with_units(folder: Path, **units: Any) -> Path:
    """An HDF5 file with an attribute ``units`` at some of its datasets, as h5py writes what it is given."""
    path = hdf5(folder, **{"t": T, "q.a": T, "power": T})
    with h5py.File(path, "r+") as file:
        for name, unit in units.items():
            file[name.replace("__", ".")].attrs["units"] = unit
    return path


def test_units_by_plain_h5py(tmp_path: Path) -> None:
    """Text of variable length is read: SI passes, anything else is refused or converted by a map."""
    rec = fd.read_recording(with_units(tmp_path, t="s", q__a="radians", power="W"))
    assert (rec.unit("q.a"), rec.unit("power")) == ("rad", "W")
    assert fd.read_recording(with_units(tmp_path, q__a=np.array(["m"], h5py.string_dtype()))).unit("q.a") == "m"
    path = with_units(tmp_path, q__a="deg", t="ms")
    with pytest.raises(
        InputError, match=r"q\.a: the unit is not SI, got 'deg'; convert it to rad or m, or read it with"
    ):
        fd.read_recording(path)
    rec = fd.read_recording(path, map=channel_map(channels={"q.a": "q.a"}))
    np.testing.assert_array_equal(rec.t, T / 1000)
    np.testing.assert_allclose(rec["q.a"], np.deg2rad(T), rtol=1e-15)


@pytest.mark.parametrize("unit", [3.0, "x" * 2000, np.array(["rad", "deg"], h5py.string_dtype())])
def test_units_that_are_not_read(tmp_path: Path, unit: Any) -> None:
    """Never in silence: the line asks for a map, which can state the unit."""
    path = with_units(tmp_path, q__a=unit)
    with pytest.raises(
        InputError, match=r"q\.a: the file states the unit in a way that is not read; state it in a chan"
    ):
        fd.read_recording(path)
    with pytest.raises(
        InputError, match=r"channels\.q\.a\.unit: the file states the column's unit in a way that is not"
    ):
        fd.read_recording(path, map=channel_map(channels={"q.a": "q.a"}))
    rec = fd.read_recording(path, map=channel_map(channels={"q.a": {"from": "q.a", "unit": "rad"}}))
    np.testing.assert_array_equal(rec["q.a"], T)


def test_damaged_heaps_do_no_harm(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Wherever the heap of the texts is damaged, there is an answer, though HDF5 hangs on one of these."""
    monkeypatch.setattr("flexdyn.records.apart.server.COMPUTING_SECONDS", 1)
    path = with_units(tmp_path, q__a="deg")
    whole = path.read_bytes()
    heap = whole.index(b"GCOL")
    answers = set()
    for offset, byte in ((8, 255), (18, 255), (24, 255)):  # sizes of the heap and its texts, a count
        path.write_bytes(whole[: heap + offset] + bytes([byte]) + whole[heap + offset + 1 :])
        with pytest.raises(InputError) as caught:
            fd.read_recording(path)
        answers.add(caught.value.problem)
    assert "reading it takes more than 1 s of computing, or 10 s in all" in answers
