"""NPZ: one array per channel and ``t``, as numpy.savez writes them; no pickle is ever loaded."""

from __future__ import annotations

import os
import zipfile
from pathlib import Path
from typing import IO, Any

import numpy as np

from flexdyn.errors import InputError
from flexdyn.records.array_columns import RequestedColumn, parts_of
from flexdyn.records.bounds import MOST_COLUMNS, check_count, check_size
from flexdyn.records.meta import as_json, from_json
from flexdyn.records.recording import Recording
from flexdyn.records.request import Request
from flexdyn.records.table import RESERVED, Table, check_name, damage_named

_PIECE = 2**20
_DIRECTORY_SIZE = 5
_LONGEST_ENTRY = 400
_READERS = {(1, 0): np.lib.format.read_array_header_1_0, (2, 0): np.lib.format.read_array_header_2_0}


def write(rec: Recording, path: Path) -> None:
    """Write uncompressed arrays in order; the same recording gives the same bytes.

    Args:
        rec: the recording.
        path: of the new file.
    """
    arrays = {"t": rec.t, **rec.channels}
    if rec.meta:
        arrays[RESERVED] = np.array(as_json(rec.meta))
    with zipfile.ZipFile(path, "x", zipfile.ZIP_STORED) as archive:
        for name, array in arrays.items():
            # savez refuses some names ("file") and writes the time; our own ZipInfo does neither.
            with archive.open(zipfile.ZipInfo(f"{name}.npy"), "w", force_zip64=True) as member:
                np.lib.format.write_array(member, array, version=(1, 0), allow_pickle=False)


def read(path: Path, request: Request) -> Table:
    """Read arrays after checking their headers; a map may use ``q[:,0]``, a column of an array.

    Args:
        path: of the file.
        request: what is wanted, and how the file is laid out.

    Raises:
        InputError: not an NPZ file, truncated, objects inside, or impossible sizes.
    """
    table = Table()
    with damage_named("not an NPZ file, or truncated"):
        _check_directory(path)
        archive = zipfile.ZipFile(path)
    with archive:
        members = archive.infolist()
        check_count(len(members))
        check_size(sum(member.file_size for member in members), os.path.getsize(path))
        names = [_name_of(member, by_convention=not request.mapped) for member in members]
        arrays = [name for name in names if name != RESERVED]
        parts = parts_of(arrays if request.columns is None else request.columns, arrays)
        for done, (name, member) in enumerate(zip(names, members, strict=True)):
            wanted = [part for part in parts if part.array == name]
            if not wanted and name != RESERVED:
                continue
            with damage_named(f"the array {name} cannot be read"), archive.open(member) as stream:
                array = _array(stream, member.file_size, name, wanted)
                if name == RESERVED:
                    table.meta = from_json(str(array))
                for part in wanted:
                    table.add(part.key, part.of(array))
            request.report((done + 1) / len(members))
    return table


def _check_directory(path: Path) -> None:
    """Refuse a table of contents that is too long, before zipfile makes objects of it."""
    with open(path, "rb") as stream:
        end = zipfile._EndRecData(stream)  # type: ignore[attr-defined]  # the number that zipfile itself uses
    if end is not None and end[_DIRECTORY_SIZE] > MOST_COLUMNS * _LONGEST_ENTRY:
        check_count(end[_DIRECTORY_SIZE] // _LONGEST_ENTRY)


def _name_of(member: zipfile.ZipInfo, *, by_convention: bool) -> str:
    """Name of an array without its ending; other members of the archive are refused."""
    name = member.filename.removesuffix(".npy")
    if name == member.filename or member.compress_type not in (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED):
        remedy = "write it with numpy.savez"
        raise InputError("the file holds more than NumPy's arrays", value=member.filename, remedy=remedy)
    if by_convention and name not in ("t", RESERVED):
        check_name(name)
    return name


def _array(stream: IO[bytes], size: int, name: str, parts: list[RequestedColumn]) -> np.ndarray[Any, np.dtype[Any]]:
    """One array of a member of `size` bytes; nothing is allocated before type, shape and size agree."""
    reader = _READERS.get(np.lib.format.read_magic(stream))
    if reader is None:
        raise InputError("the column has named fields", remedy="write plain arrays of doubles", channel=name)
    shape, by_columns, dtype = reader(stream)
    if name == RESERVED and (shape != () or dtype.kind != "U"):
        raise InputError("meta is not one JSON text", key=name, remedy="write it with write_recording")
    for part in parts:
        part.check(dtype, shape)
    expected = int(np.prod(shape, dtype=object)) * dtype.itemsize
    if expected != size - stream.tell():
        problem = f"{size - stream.tell()} bytes where the shape {shape} needs {expected}"
        raise InputError(problem, key=name, channel=name)
    array = np.empty(shape, dtype, order="F" if by_columns else "C")
    buffer = array.reshape(-1, order="A").view(np.uint8).data
    filled = 0
    while piece := stream.read(_PIECE):
        buffer[filled : filled + len(piece)] = piece
        filled += len(piece)
    if filled != expected:
        remedy = "copy the file again"
        raise InputError(f"cut after {filled} of {expected} bytes", key=name, remedy=remedy, channel=name)
    return array
