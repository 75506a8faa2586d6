"""HDF5: files by h5py's own hand are read; what leads out of the file is refused."""

from __future__ import annotations

import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest

from flexdyn.errors import InputError, MissingExtra
from flexdyn.records import Recording, read_recording, write_recording

T = np.array([0.0, 0.1, 0.2])


def made(path: Path, fill: Callable[[Any], None]) -> Path:
    """A file with ``t`` and whatever `fill` puts into it."""
    with h5py.File(path, "w") as file:
        file["t"] = T
        fill(file)
    return path


def test_flat_and_grouped_files_by_h5py(tmp_path: Path) -> None:
    """Flat names, groups by signal, compression and chunks make no difference."""

    def fill(file: Any) -> None:
        file["q.elbow"] = np.array([1, 2, 3], ">i4")
        file.create_dataset("q/wrist", data=T, chunks=(2,), compression="gzip", shuffle=True, fletcher32=True)
        file["tau/arm.one"] = T.astype(np.float32)
        file["tau/arm.one"].attrs["units"] = "N m"

    rec = read_recording(made(tmp_path / "log.h5", fill))
    assert set(rec.channels) == {"q.elbow", "q.wrist", "tau.arm.one"}
    np.testing.assert_array_equal(rec["q.elbow"], [1.0, 2.0, 3.0])
    np.testing.assert_array_equal(rec["q.wrist"], T)
    np.testing.assert_array_equal(rec["tau.arm.one"], T.astype(np.float32))


def test_what_is_written_has_units_and_order(tmp_path: Path) -> None:
    """h5py alone finds every channel in order, with its unit."""
    rec = Recording(T, {"tau.b": T, "q.a": T, "power": T}, meta={"units": {"q.a": "m"}})
    write_recording(rec, tmp_path / "log.hdf5")
    with h5py.File(tmp_path / "log.hdf5") as file:
        assert list(file) == ["t", "tau.b", "q.a", "power", "__meta__"]
        units = [file[name].attrs["units"].decode() for name in ("t", "tau.b", "q.a", "power")]
        assert units == ["s", "N m", "m", ""]
        assert file["q.a"].dtype == np.dtype("<f8")


@pytest.mark.parametrize("name", ["q.arm/one", "a/b", "..", "100 %", "q.a%2Fb", "\u03c4 \u0394/\u00fc", "a//b", "/a"])
def test_any_name_comes_back(tmp_path: Path, name: str) -> None:
    """Slashes and percent signs come back as the names had them."""
    rec = Recording(T, {name: T, "q.a": -T})
    write_recording(rec, tmp_path / "log.h5")
    assert read_recording(tmp_path / "log.h5") == rec


def test_units_of_a_file_are_believed_or_refused(tmp_path: Path) -> None:
    """Metres are remembered; degrees are refused, for the numbers would be taken as radians."""

    def fill(unit: bytes, on: str = "q.a") -> Callable[[Any], None]:
        def inner(file: Any) -> None:
            file["q.a"] = T
            file["power"] = T
            file[on].attrs["units"] = np.bytes_(unit)

        return inner

    path = tmp_path / "log.h5"
    assert read_recording(made(path, fill(b"m"))).meta == {"units": {"q.a": "m"}}
    assert read_recording(made(path, fill(b"radians"))).meta == {}
    assert read_recording(made(path, fill(b"W", "power"))).unit("power") == "W"
    for unit, on in ((b"deg", "q.a"), (b"ms", "t")):
        with pytest.raises(InputError, match=f"{on}: the unit is not SI, got '{unit.decode()}'"):
            read_recording(made(path, fill(unit, on)))


def links_out(file: Any) -> None:
    """A channel that lies in another file."""
    file["q.a"] = h5py.ExternalLink("other.h5", "/q.a")


def links_softly(file: Any) -> None:
    """A channel that is a path."""
    file["q.a"] = h5py.SoftLink("/t")


def links_deep(file: Any) -> None:
    """A grouped channel that lies in another file."""
    file.create_group("q")["a"] = h5py.ExternalLink("other.h5", "/q.a")


def maps_out(file: Any) -> None:
    """A virtual dataset over another file."""
    layout = h5py.VirtualLayout((3,), "f8")
    layout[:] = h5py.VirtualSource("other.h5", "q.a", (3,))
    file.create_virtual_dataset("q.a", layout)


def stores_out(file: Any) -> None:
    """A dataset whose bytes are those of any other file."""
    file.create_dataset("q.a", (3,), "f8", external=[("other.h5", 0, 24)])


def turns_round(file: Any) -> None:
    """A group that holds its own parent."""
    file.create_group("q")["a"] = file["/"]


def announces_much(file: Any) -> None:
    """A dataset of a terabyte that was never written."""
    file.create_dataset("q.a", (2**37,), "f8", chunks=(1024,), compression="gzip")


def chunks_much(file: Any) -> None:
    """Three samples in a chunk of two gigabytes."""
    file.create_dataset("q.a", (3,), "f8", chunks=(2**28,), maxshape=(None,))


def twice(file: Any) -> None:
    """A channel both flat and grouped."""
    file["q.a"] = T
    file["q/a"] = T


def strange_group(file: Any) -> None:
    """A group that is no signal."""
    file["run/q.a"] = T


def has_nan(file: Any) -> None:
    """A gap."""
    file["q.a"] = [0.0, np.nan, 1.0]


def has_text(file: Any) -> None:
    """Text for numbers."""
    file["q.a"] = ["a", "b", "c"]


def is_flat(file: Any) -> None:
    """One number for a column."""
    file["q.a"] = 1.0


def is_nothing(file: Any) -> None:
    """A dataset without a shape."""
    file["q.a"] = h5py.Empty("f8")


def is_short(file: Any) -> None:
    """A sample too few."""
    file["q.a"] = T[:2]


def loose_meta(file: Any) -> None:
    """Meta that HDF5 keeps in its heap."""
    file["q.a"] = T
    file["__meta__"] = '{"a": 1}'


@pytest.mark.parametrize(
    ("fill", "words"),
    [
        (links_out, "link leads out of the file, got 'q.a'"),
        (links_softly, "link leads out of the file, got 'q.a'"),
        (links_deep, "link leads out of the file, got 'a'"),
        (maps_out, "q.a: the samples lie in another file"),
        (stores_out, "q.a: the samples lie in another file"),
        (turns_round, "q.a: the channel is no dataset"),
        (announces_much, "declares 1099511"),
        (chunks_much, "q.a: a chunk is larger than 1 GiB"),
        (twice, "q.a: the channel is there twice"),
        (strange_group, "the group is no signal, got 'run'"),
        (has_nan, "q.a: row 1: not a finite number"),
        (has_text, "q.a: the column holds objects"),
        (is_flat, r"q.a: the column has the shape \(\)"),
        (is_nothing, r"q.a: the column has the shape \(\)"),
        (is_short, "q.a: 2 samples where t has 3"),
        (loose_meta, "meta is not one JSON text"),
        (lambda file: file.pop("t"), "no column t"),
    ],
)
def test_what_is_no_recording_is_refused(tmp_path: Path, fill: Callable[[Any], None], words: str) -> None:
    """One line; nothing outside the file is opened, nothing is unpacked that the file cannot hold."""
    made(tmp_path / "other.h5", lambda file: file.create_dataset("q.a", data=T))
    path = made(tmp_path / "log.h5", fill)
    with pytest.raises(InputError, match=words) as caught:
        read_recording(path)
    assert str(caught.value).startswith(str(path))
    assert "\n" not in str(caught.value)


def test_without_h5py_the_extra_is_named(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Reading and writing say what to install, and leave nothing behind."""
    rec = Recording(T, {"q.a": T})
    write_recording(rec, tmp_path / "log.h5")
    before = (tmp_path / "log.h5").read_bytes()
    monkeypatch.setitem(sys.modules, "h5py", None)
    with pytest.raises(MissingExtra, match=r"flexdyn\[hdf5\]"):
        read_recording(tmp_path / "log.h5")
    with pytest.raises(MissingExtra, match=r"flexdyn\[hdf5\]"):
        write_recording(rec, tmp_path / "log.h5")
    assert [path.name for path in tmp_path.iterdir()] == ["log.h5"]
    assert (tmp_path / "log.h5").read_bytes() == before
