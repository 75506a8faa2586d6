"""Files that promise more than they hold: refused by one line that names the bound, before memory or time is gone."""

from __future__ import annotations

import io
import resource
import zipfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest
import scipy.io

import flexdyn as fd
from flexdyn.records import bounds
from tests.fuzz.corpus import URDF


def header(shape: tuple[int, ...]) -> bytes:
    """The head of an array of doubles."""
    stream = io.BytesIO()
    np.lib.format.write_array_header_1_0(stream, {"descr": "<f8", "fortran_order": False, "shape": shape})
    return stream.getvalue()


def promising(path: Path) -> None:
    """An NPZ file whose arrays have a header of gigabytes and no samples."""
    with zipfile.ZipFile(path, "w") as archive:
        for name in ("t", "q.a"):
            archive.writestr(f"{name}.npy", header((10**9,)))


def of_zeros(path: Path) -> None:
    """An NPZ file of 1 MB that unpacks to a gigabyte."""
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED, compresslevel=1) as archive:
        for name in ("t", "q.a"):
            with archive.open(f"{name}.npy", "w", force_zip64=True) as stream:
                stream.write(header((2**25,)))
                for _ in range(16):
                    stream.write(bytes(2**24))


def of_members(path: Path) -> None:
    """An NPZ file of very many empty arrays: its table of contents, 100,000 times over."""
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr("x.npy", b"")
    data = path.read_bytes()
    at, end = data.index(b"PK\x01\x02"), data.index(b"PK\x05\x06")
    entry, tail = data[at:end] * 100_000, bytearray(data[end:])
    tail[8:16] = (65535).to_bytes(2, "little") * 2 + len(entry).to_bytes(4, "little")
    path.write_bytes(data[:at] + entry + bytes(tail))


def npz_columns(path: Path) -> None:
    """An NPZ file of too many arrays."""
    with zipfile.ZipFile(path, "w") as archive:
        for k in range(bounds.MOST_COLUMNS + 1):
            archive.writestr(f"q.{k}.npy", b"")


def csv_columns(path: Path) -> None:
    """A table of too many columns."""
    path.write_text("t" + "".join(f",q.{k}" for k in range(bounds.MOST_COLUMNS)) + "\n0\n")


def h5_columns(path: Path) -> None:
    """An HDF5 file of too many datasets: one of them under very many names."""
    with h5py.File(path, "w", libver="latest") as file:
        file["t"] = [0.0, 1.0]
        for k in range(bounds.MOST_COLUMNS):
            file[f"q.{k}"] = file["t"]


def mat_columns(path: Path) -> None:
    """A MAT-file of too many variables."""
    values: Any = np.array([0.0, 1.0])
    scipy.io.savemat(path, {"t": values} | {f"p{k}": values for k in range(bounds.MOST_COLUMNS)})


def parquet_columns(path: Path) -> None:
    """A Parquet file of too many columns."""
    import pyarrow as pa
    from pyarrow import parquet

    parquet.write_table(pa.table({f"q.{k}": pa.array([], "f8") for k in range(bounds.MOST_COLUMNS + 1)}), path)


@pytest.mark.parametrize(
    ("make", "suffix", "words"),
    [
        (promising, ".npz", "t: 0 bytes where the shape (1000000000,) needs 8000000000"),
        (of_zeros, ".npz", "declares 536871168 bytes of arrays"),
        (of_members, ".npz", "more than 10000 columns"),
        (npz_columns, ".npz", "more than 10000 columns"),
        (csv_columns, ".csv", "more than 10000 columns"),
        (h5_columns, ".h5", "more than 10000 columns"),
        (mat_columns, ".mat", "more than 10000 columns"),
        (parquet_columns, ".parquet", "more than 10000 columns"),
    ],
)
def test_recordings(tmp_path: Path, make: Callable[[Path], None], suffix: str, words: str) -> None:
    """One line names the bound, and less memory is taken than 100 MB."""
    make(tmp_path / f"bomb{suffix}")
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    with pytest.raises(fd.InputError) as caught:
        fd.read_recording(tmp_path / f"bomb{suffix}")
    line = str(caught.value)
    assert words in line
    assert line.isprintable()
    assert resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before < 100_000


def test_what_a_file_may_unpack_to() -> None:
    """Small files may be packed as tight as deflate packs zeros; large ones as tight as measurements ever are."""
    assert bounds.most_bytes(1000) == 1_100_000
    assert bounds.most_bytes(2**20) == 2**28
    assert bounds.most_bytes(2**24) == 2**30
    assert bounds.most_bytes(2**40) == bounds.MOST_BYTES


def chain(joints: int) -> str:
    """A URDF of links in a row."""
    links = "".join(f'<link name="l{k}"/>' for k in range(joints + 1))
    ends = ((f"l{k}", f"l{k + 1}") for k in range(joints))
    moving = "".join(
        f'<joint name="j{k}" type="continuous"><parent link="{parent}"/><child link="{child}"/></joint>'
        for k, (parent, child) in enumerate(ends)
    )
    return f'<robot name="chain">{links}{moving}</robot>'


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (chain(201), "201 joints move, more than 200"),
        (chain(1000), "1001 links, more than 1000"),
        ("<robot><link " + " ".join(f'a{k}="1"' for k in range(200_000)) + "/></robot>", "attributes, more than 1000"),
        ("<robot>" + "<x>" * 300 + "</x>" * 300 + "</robot>", "Excessive depth in document: 256"),
        (URDF.decode().replace('"base"', f'"{"x" * 100_000}"', 1), "the name is longer than 200 characters"),
        (URDF.decode().replace('"base"', '"\u202ebase\x9b31m"', 1), "the name holds characters that do not print"),
        (URDF.decode().replace('link="base"', f'link="{"x" * 100_000}"', 1), "xxx' is not declared"),
    ],
)
def test_urdfs(tmp_path: Path, text: str, words: str) -> None:
    """One line names the bound; long and hostile names are cut and made harmless in it."""
    (tmp_path / "arm.urdf").write_text(text)
    with pytest.raises(fd.InputError) as caught:
        fd.load_robot(tmp_path / "arm.urdf")
    line = str(caught.value)
    assert words in line
    assert line.isprintable()
    assert len(line) < 1500


def test_a_path_that_is_no_text_is_one_line(tmp_path: Path) -> None:
    """A study whose key is a number is refused by name; it ended in an AttributeError."""
    study = "flexdyn_study: 1\nmodel: scara_two_link\nduration: 0.1\nkeep: [q]\nruns: 2\nvary: {7: {uniform: [1, 2]}}\n"
    (tmp_path / "study.yaml").write_text(study)
    with pytest.raises(fd.InputError, match=r"vary\.7: no such number in the model or command"):
        fd.run_study(tmp_path / "study.yaml", tmp_path / "out.zarr")
