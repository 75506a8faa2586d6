"""MAT-files made by hand, byte by byte: other machines, MATLAB's own objects, and what is made to do harm."""

from __future__ import annotations

import struct
import zlib
from collections.abc import Callable
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest
import scipy.io

from flexdyn.errors import InputError
from flexdyn.records import Recording, read_recording
from flexdyn.records.matlab import file as mat_file
from flexdyn.records.request import Request

T = np.array([0.0, 0.1, 0.2])
CUT = "not a MAT-file, or truncated .*could not read bytes"


def read(path: Path, *columns: str | int) -> dict[str, Any]:
    """Columns asked for as a channel map does."""
    return mat_file.read(path, Request(columns=frozenset(columns), mapped=True)).columns


def element(kind: int, data: bytes, order: str = "<") -> bytes:
    """An element of a MAT-file."""
    return struct.pack(order + "II", kind, len(data)) + data + b"\0" * (-len(data) % 8)


def matrix(kind: int, name: str, shape: tuple[int, ...], *parts: bytes, order: str = "<") -> bytes:
    """A variable: class, shape, name, and whatever follows."""
    flags = element(6, struct.pack(order + "II", kind, 0), order)
    extents = element(5, struct.pack(f"{order}{len(shape)}i", *shape), order)
    return element(14, flags + extents + element(1, name.encode(), order) + b"".join(parts), order)


def column(name: str, values: Any, order: str = "<") -> bytes:
    """A variable of doubles, one column."""
    data = np.asarray(values, order + "f8").tobytes()
    return matrix(6, name, (len(values), 1), element(9, data, order), order=order)


def saved(folder: Path, *variables: bytes, order: str = "<") -> Path:
    """A file made by hand."""
    mark = b"IM" if order == "<" else b"MI"
    head = b"MATLAB 5.0 MAT-file".ljust(124) + struct.pack(order + "H", 0x100) + mark
    (folder / "log.mat").write_bytes(head + b"".join(variables))
    return folder / "log.mat"


def test_big_endian_files(tmp_path: Path) -> None:
    """Files of other machines have their bytes the other way round."""
    path = saved(tmp_path, column("t", T, ">"), column("power", 2 * T, ">"), order=">")
    np.testing.assert_array_equal(scipy.io.loadmat(path)["power"][:, 0], 2 * T)
    assert read_recording(path).same_as(Recording(T, {"power": 2 * T}))


def test_function_handles_and_objects_do_not_disturb(tmp_path: Path) -> None:
    """A timeseries or a function handle beside the data is passed over, and named where it is asked for."""
    handle = matrix(16, "f", (1, 1), column("", T))
    flags = element(6, struct.pack("<II", 17, 0))
    opaque = element(14, flags + element(1, b"None") + element(1, b"MCOS") + element(1, b"function_handle"))
    own = matrix(9, "", (4, 1), element(2, b"abcd"))
    path = saved(tmp_path, opaque, handle, column("t", T), column("power", T), own)
    assert read_recording(path).same_as(Recording(T, {"power": T}))
    for name, words in (("None", "an object"), ("f", "a function handle")):
        with pytest.raises(InputError, match=f"{name} is {words}, not numbers"):
            read(path, name)


def nested(depth: int) -> bytes:
    """A struct in a struct in a struct."""
    innermost = column("", T)
    field = struct.pack("<HHI", 5, 4, 2) + element(1, b"a\0")
    inner, outermost = (matrix(2, name, (1, 1), field)[8:] for name in ("", "x"))
    heads, length = [], len(innermost)
    for level in range(depth):
        head = outermost if level == depth - 1 else inner
        length += len(head)
        heads.append(struct.pack("<II", 14, length) + head)
        length += 8
    return b"".join(reversed(heads)) + innermost


@pytest.mark.parametrize(
    ("variable", "words"),
    [
        (nested(17), "structs nest deeper than 16"),
        (nested(30_000), r"the library that reads it crashed \(SIGSEGV\)"),
        (element(15, zlib.compress(nested(200_000), 1)), "not a MAT-file, or truncated|crashed"),
        (
            element(15, zlib.compress(matrix(6, "x", (2**17, 1), element(9, bytes(2**17))))),
            CUT,
        ),
        (matrix(6, "x", (2**31 - 1, 1), element(9, bytes(24))), "declares 17179869200 bytes"),
        (matrix(6, "x", (1,) * 40, element(9, bytes(8))), "malformed input file"),
        (matrix(6, "x", (3, 1), element(77, bytes(24))), r"the library that reads it crashed \(SIGSEGV\)"),
        (matrix(6, "x", (3, 1), struct.pack("<II", 9, 2**32 - 1)), "takes more than .* bytes of memory"),
        (struct.pack("<II", 14, 2**31), CUT),
        (element(15, b"no deflate"), "not a MAT-file, or truncated"),
        (element(15, zlib.compress(b"x")), "not a MAT-file, or truncated"),
        (
            element(15, zlib.compress(column("x", T))[:-4] + bytes(4)),
            "not a MAT-file, or truncated .*incorrect data check",
        ),
        (element(15, zlib.compress(column("x", T))[:-4]), CUT),
        (element(15, zlib.compress(column("x", T) + bytes(8))), "not a MAT-file, or truncated"),
        (matrix(2, "x", (1, 1), struct.pack("<HHI", 5, 4, 0), element(1, b"a")), "not a MAT-file, or truncated"),
        (column("x", T) + column("x", T), 'Duplicate variable name "x"'),
    ],
    ids=lambda value: value if isinstance(value, str) else "",
)
def test_hostile_files_are_refused(tmp_path: Path, variable: bytes, words: str) -> None:
    """Depth, sizes and types that some readers follow into a crash are answered with a line."""
    with pytest.raises(InputError, match=words):
        read_recording(saved(tmp_path, column("t", T), variable))


@pytest.mark.parametrize(
    ("fill", "name", "words"),
    [
        (lambda file: file.update({"q": h5py.ExternalLink("other.mat", "/q")}), "q", "a link leads out of the file"),
        (lambda file: file.update({"q": h5py.SoftLink("/t")}), "q", "a link leads out of the file"),
        (lambda file: file.create_group("q").update({"a": file["/"]}), "q.a", "structs nest deeper"),
        (
            lambda file: file.create_dataset("q", (1, 3), "f8", external=[("other", 0, 24)]),
            "q",
            "samples lie in another",
        ),
        (
            lambda file: file.create_dataset("q", (1, 2**37), "f8", chunks=(1, 1024)),
            "q",
            "declares 1099511627776 bytes",
        ),
        (lambda file: file.create_dataset("q", data=["a"]), "q", "not numbers"),
        (lambda file: file.create_dataset("q", data=h5py.Empty("f8")), "q", "q is an empty array, not numbers"),
    ],
)
def test_hostile_files_of_version_73_are_refused(
    tmp_path: Path, fill: Callable[[Any], Any], name: str, words: str
) -> None:
    """Nothing outside the file is opened, no cycle is followed, nothing is unpacked that cannot be."""
    path = tmp_path / "log.mat"
    with h5py.File(path, "w", userblock_size=512) as file:
        file["t"] = T.reshape(1, 3)
        fill(file)
    with pytest.raises(InputError, match=words):
        read(path, name)


@pytest.mark.parametrize("data", [b"", b"x" * 600, b"\x89HDF\r\n\x1a\n" + bytes(600)])
def test_files_of_another_kind(tmp_path: Path, data: bytes) -> None:
    """Noise is said to be none."""
    (tmp_path / "log.mat").write_bytes(data)
    with pytest.raises(InputError, match="not a MAT-file"):
        read_recording(tmp_path / "log.mat")
