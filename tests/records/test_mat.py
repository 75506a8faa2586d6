"""MAT-files: SciPy and h5py are the other hand; what MATLAB users have is read, hostile files are refused."""

from __future__ import annotations

import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest
import scipy.io

from flexdyn.errors import InputError, MissingExtra
from flexdyn.records import Recording, read_recording, write_recording
from flexdyn.records.matlab import file as mat_file
from flexdyn.records.request import Request

T = np.array([0.0, 0.1, 0.2])
GRID = np.arange(12.0).reshape(4, 3)
ODD = (
    "q.arm/one",
    "q.end",
    "tau.1",
    "a b",
    "power",
    "other",
    "flexdyn",
    "\u03c4",
    "q." + "x" * 64,
    "q",
    "end",
    "q.a.b",
)


def read(path: Path, *columns: str | int) -> dict[str, Any]:
    """Columns asked for as a channel map does."""
    return mat_file.read(path, Request(columns=frozenset(columns), mapped=True)).columns


@pytest.fixture(params=["v5", "v7.3"])
def version(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> str:
    """Both versions that are written: 7.3 is for variables of 2 GB, so the limit is lowered."""
    if request.param == "v7.3":
        monkeypatch.setattr(mat_file, "LARGEST_V5", 0)
    return str(request.param)


def test_any_name_order_and_meta_come_back(tmp_path: Path, version: str) -> None:
    """Names that MATLAB could not have, channels of signals mixed, meta: nothing is lost."""
    channels = {"q.a": T, "tau.a": -T, "q.b": 2 * T, **{name: T + k for k, name in enumerate(ODD)}}
    rec = Recording(T, channels, meta={"units": {"q.a": "m"}, "note": "\u00fc \ud83d\x00", "n": [1, None]})
    write_recording(rec, tmp_path / "log.mat")
    assert read_recording(tmp_path / "log.mat") == rec
    assert h5py.is_hdf5(tmp_path / "log.mat") == (version == "v7.3")


def test_doubles_come_back_bit_for_bit(tmp_path: Path, version: str) -> None:
    """Subnormals, minus zero, extremes and neighbours of one."""
    values = [5e-324, -0.0, 1.7976931348623157e308, -2.2250738585072014e-308, np.nextafter(1, 2), np.nextafter(1, 0)]
    rec = Recording(np.arange(6.0), {"q.a": values})
    write_recording(rec, tmp_path / "log.mat")
    assert read_recording(tmp_path / "log.mat") == rec


def test_what_is_written_is_natural_in_matlab(tmp_path: Path) -> None:
    """SciPy sees t as a column, a struct per signal, and the other channels as variables."""
    write_recording(Recording(T, {"q.elbow": T, "q.wrist": 2 * T, "power": 3 * T, "q.a b": T}), tmp_path / "log.mat")
    there = scipy.io.loadmat(tmp_path / "log.mat")
    assert there["t"].shape == (3, 1)
    assert there["q"].dtype.names == ("elbow", "wrist")
    np.testing.assert_array_equal(there["q"][0, 0]["wrist"][:, 0], 2 * T)
    np.testing.assert_array_equal(there["power"][:, 0], 3 * T)
    np.testing.assert_array_equal(there["other"][0, 0]["c1"][:, 0], T)


def test_version_73_is_written_as_matlab_does(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """512 bytes of header, arrays transposed, structs as groups, each with its class."""
    monkeypatch.setattr(mat_file, "LARGEST_V5", 0)
    write_recording(Recording(T, {"q.elbow": T}), tmp_path / "log.mat")
    head = (tmp_path / "log.mat").read_bytes()[:512]
    assert head.startswith(b"MATLAB 7.3 MAT-file")
    assert head[124:128] == b"\x00\x02IM"
    with h5py.File(tmp_path / "log.mat") as file:
        assert file.userblock_size == 512
        assert file["q"].attrs["MATLAB_class"] == b"struct"
        assert file["q/elbow"].attrs["MATLAB_class"] == b"double"
        assert file["q/elbow"].shape == (1, 3)
        assert file["flexdyn"].attrs["MATLAB_class"] == b"char"


@pytest.mark.parametrize("compressed", [False, True])
@pytest.mark.parametrize("oned_as", ["row", "column"])
def test_scipy(tmp_path: Path, compressed: bool, oned_as: Any) -> None:
    """Rows or columns, compressed or not, integers and logicals; text and cells beside them do not disturb."""
    cells = np.empty(2, object)
    cells[:] = ["a", GRID]
    there = {
        "t": T,
        "q": {"elbow": T.astype(np.float32), "wrist": np.array([1, 2, 3], np.int16)},
        "on": np.array([True, False, True]),
        "note": "measured",
        "cells": cells,
    }
    scipy.io.savemat(tmp_path / "log.mat", there, do_compression=compressed, oned_as=oned_as)
    expected: dict[str, Any] = {"q.elbow": T.astype(np.float32), "q.wrist": [1, 2, 3], "on": [1, 0, 1]}
    assert read_recording(tmp_path / "log.mat").same_as(Recording(T, expected))


def test_noise_that_does_not_compress(tmp_path: Path) -> None:
    """Deflate makes such data longer than they are."""
    noise = np.random.default_rng(8).integers(0, 256, 100_000, np.uint8)
    t = np.arange(100_000.0)
    scipy.io.savemat(tmp_path / "log.mat", {"t": t, "noise": noise}, do_compression=True)
    assert read_recording(tmp_path / "log.mat") == Recording(t, {"noise": noise})


def matlab_73(path: Path) -> Path:
    """A file of version 7.3 with a nested struct, an array and a cell, as MATLAB lays it out."""
    with h5py.File(path, "w", userblock_size=512) as file:
        for name, values in {
            "rec/time": T.reshape(3, 1),
            "rec/deep/pos": GRID.T,
            "on": np.array([[1, 0, 1]], np.uint8),
            "note": np.array([[104], [105]], np.uint16),
            "#refs#/a": T.reshape(1, 3),
            "nothing": np.array([0, 0], np.uint64),
        }.items():
            file[name] = values
            file[name].attrs["MATLAB_class"] = np.bytes_("double")
        file["note"].attrs["MATLAB_class"] = np.bytes_("char")
        file["on"].attrs["MATLAB_class"] = np.bytes_("logical")
        file["nothing"].attrs["MATLAB_empty"] = np.uint8(1)
        file["rec"].attrs["MATLAB_class"] = np.bytes_("struct")
        file["cells"] = np.array([[file["#refs#/a"].ref]], h5py.ref_dtype)
        file["cells"].attrs["MATLAB_class"] = np.bytes_("cell")
        file["z"] = np.zeros((1, 3), [("real", "f8"), ("imag", "f8")])
    head = b"MATLAB 7.3 MAT-file, Platform: GLNXA64 HDF5 schema 1.00 .".ljust(124) + b"\x00\x02IM"
    with open(path, "rb+") as stream:
        stream.write(head)
    return path


def scipy_5(path: Path) -> Path:
    """The same content in version 5."""
    cells = np.empty((1, 1), object)
    cells[0, 0] = T
    content = {"rec": {"time": T.reshape(1, 3), "deep": {"pos": GRID}}, "on": T > 0, "note": "hi", "cells": cells}
    scipy.io.savemat(path, {**content, "z": T + 1j, "nothing": np.empty((0, 0))}, do_compression=True)
    return path


@pytest.mark.parametrize("make", [scipy_5, matlab_73])
def test_columns_are_named_as_in_matlab(tmp_path: Path, make: Callable[[Path], Path]) -> None:
    """Dots lead into structs, brackets take rows and columns from 1, spaces do not matter."""
    path = make(tmp_path / "log.mat")
    there = read(path, "rec.time", "rec.time(1,:)", "rec.deep.pos(4,:)", "rec.deep.pos( :, 2 )", "on")
    np.testing.assert_array_equal(there["rec.time"], T)
    np.testing.assert_array_equal(there["rec.time(1,:)"], T)
    np.testing.assert_array_equal(there["rec.deep.pos(4,:)"], GRID[3])
    np.testing.assert_array_equal(there["rec.deep.pos( :, 2 )"], GRID[:, 1])
    assert set(there["on"]) <= {0.0, 1.0}


@pytest.mark.parametrize("make", [scipy_5, matlab_73])
@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("rec.tme", r"rec\.tme: no such column; did you mean 'rec\.time'"),
        ("rec", "rec: no such column; "),
        ("rec.deep.pos", r"an array, not a column: rec\.deep\.pos \(4x3\); take a row or column"),
        ("rec.deep.pos(5,:)", r"no such row or column; it is rec\.deep\.pos \(4x3\); rows and columns count from 1"),
        ("rec.deep.pos(0,:)", "no such row or column"),
        ("rec.deep.pos(1,2)", "not the name of a column in a MAT file; write it as MATLAB does"),
        ("rec.deep.pos(:,:)", "not the name of a column"),
        ("rec.deep.pos(", "not the name of a column"),
        ("note", "note is text, not numbers; in MATLAB, save plain arrays"),
        ("cells", "cells is a cell array, not numbers"),
        ("z", "z is complex numbers, not numbers"),
    ],
)
def test_what_is_no_column_is_named(tmp_path: Path, make: Callable[[Path], Path], name: str, words: str) -> None:
    """One line with the column as it was asked for, and the near miss."""
    with pytest.raises(InputError, match=words) as caught:
        read(make(tmp_path / "log.mat"), name)
    assert "\n" not in str(caught.value)


def test_a_number_is_no_name_here(tmp_path: Path) -> None:
    """Columns by number are for text files."""
    with pytest.raises(InputError, match="1: not the name of a column in a MAT file"):
        read(scipy_5(tmp_path / "log.mat"), 1)


@pytest.mark.parametrize("make", [scipy_5, matlab_73])
def test_without_t_the_candidates_are_listed(tmp_path: Path, make: Callable[[Path], Path]) -> None:
    """A file of other habits is answered with what is there, and its shape."""
    with pytest.raises(InputError, match=r"no column t; .*channel map.*rec\.time \(1x3\)"):
        read_recording(make(tmp_path / "log.mat"))


@pytest.mark.parametrize(
    ("more", "words"),
    [
        ({"kp": 3.0}, "kp: 1 values where t has 3; say in a channel map which columns to read"),
        ({"pos": GRID}, r"pos: an array, not a column: pos \(4x3\); a channel map takes its rows or columns"),
        ({"q": {"a": [0.0, np.nan, 1.0]}}, r"q\.a: row 2: not a finite number, got nan"),
        ({"n": np.array([2**53 + 1, 0, 0])}, r"n: integers beyond 2\^53"),
        ({"flexdyn": "{"}, "flexdyn: not the text that belongs there"),
        ({"flexdyn": '{"channels": [["q.a", "x"]], "meta": {}}'}, "x: the column is not there, and flexdyn lists it"),
    ],
)
def test_what_is_no_recording_is_refused(tmp_path: Path, more: dict[str, Any], words: str) -> None:
    """Without a map every number in the file must be a channel; rows count from 1, as MATLAB does."""
    scipy.io.savemat(tmp_path / "log.mat", {"t": T, "v": {"a": T}, **more})
    with pytest.raises(InputError, match=words):
        read_recording(tmp_path / "log.mat")


def test_struct_arrays_are_refused(tmp_path: Path) -> None:
    """A field of many structs is no column."""
    scipy.io.savemat(tmp_path / "log.mat", {"t": T, "s": np.array([(1.0,), (2.0,)], [("x", "f8")])})
    with pytest.raises(InputError, match=r"s\.x: s is a struct array, not numbers"):
        read(tmp_path / "log.mat", "s.x")


def test_version_4_is_answered_with_the_remedy(tmp_path: Path) -> None:
    """Old files are saved again."""
    scipy.io.savemat(tmp_path / "log.mat", {"t": T, "power": T}, format="4")
    with pytest.raises(InputError, match=r"save it again in MATLAB with save\(\.\.\., '-v7'\)"):
        read_recording(tmp_path / "log.mat")


def test_without_h5py_version_73_names_the_extra(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Version 5 needs nothing more."""
    matlab_73(tmp_path / "new.mat")
    write_recording(Recording(T, {"q.a": T}), tmp_path / "log.mat")
    monkeypatch.setitem(sys.modules, "h5py", None)
    assert len(read_recording(tmp_path / "log.mat")) == 3
    with pytest.raises(MissingExtra, match=r"flexdyn\[hdf5\]"):
        read_recording(tmp_path / "new.mat")
