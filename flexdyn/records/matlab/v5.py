"""MATLAB's MAT-file version 5 (``save -v6`` and ``-v7``), read by its tags.

SciPy's reader recurses in C as deep as the file says, so that a small hostile file can crash it, and reads structs as a
whole. This reader holds one variable at a time, limits the unpacked size, and skips variables that are not requested.
"""

from __future__ import annotations

import os
import struct
import zlib
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import IO, Any

import numpy as np
import numpy.typing as npt

from flexdyn.errors import InputError
from flexdyn.records.bounds import check_size
from flexdyn.records.matlab.columns import Leaf, LeafColumns
from flexdyn.records.matlab.v5_elements import TEXTS, Cursor, cut
from flexdyn.records.request import Request

_MATRIX, _COMPRESSED = 14, 15
_CELL, _STRUCT, _OBJECT, _CHAR, _SPARSE, _FUNCTION, _OPAQUE = 1, 2, 3, 4, 5, 16, 17
_KINDS = {
    _CELL: "a cell array",
    _OBJECT: "an object",
    _SPARSE: "a sparse array",
    _FUNCTION: "a function handle",
    _OPAQUE: "an object",
}
_NUMERIC = range(6, 16)
_COMPLEX = 0x0800
_HEAD = 2**12
_DEEPEST = 16
_MOST_DIMENSIONS = 32
_MAT_HEADER = 128
_VERSION = 0x0100


def read(path: Path, request: Request, columns: LeafColumns) -> None:
    """Pass the variables that `columns` needs to it, one after the other.

    Raises:
        InputError: no MAT-file of version 5, truncated, or impossible sizes.
    """
    size = os.path.getsize(path)
    unpacked = 0
    with open(path, "rb") as stream:
        order = _byte_order(stream.read(_MAT_HEADER))
        while stream.tell() < size:
            kind, start, stop = Cursor(stream.read(8), order).tag()
            begin = stream.tell()
            end = begin + stop - start
            if end > size:
                raise cut()
            variable = _Variable(stream, kind == _COMPRESSED, begin, end, order)
            name = variable.name() if kind in (_MATRIX, _COMPRESSED) else ""
            if name and columns.wants(name):
                unpacked += variable.length()
                check_size(unpacked, size)
                columns.take(variable.leaves())
            stream.seek(end)
            request.report(end / size)


def _byte_order(header: bytes) -> str:
    """The byte order ``<`` or ``>``; refuses a file that is no MAT-file of version 5."""
    order = {b"IM": "<", b"MI": ">"}.get(header[126:128])
    if order is None or struct.unpack(f"{order}H", header[124:126])[0] != _VERSION:
        old = 0 in header[:4] and len(header) >= 4
        remedy = "save it again in MATLAB with save(..., '-v7')" if old else "the file is damaged or of another format"
        raise InputError("not a MAT-file of version 5 or 7.3", remedy=remedy)
    return order


@dataclass(frozen=True)
class _Variable:
    """One variable of a file, from `begin` to `end`."""

    stream: IO[bytes]
    compressed: bool
    begin: int
    end: int
    order: str

    def name(self) -> str:
        """Its name; empty for MATLAB's internal variables."""
        skip = 8 if self.compressed else 0
        return _head(Cursor(self._data(skip + min(_HEAD, self.length())), self.order, skip)).name

    def length(self) -> int:
        """Its size in memory according to the file [bytes]."""
        if not self.compressed:
            return self.end - self.begin
        kind, start, stop = Cursor(self._data(8), self.order).tag()
        if kind != _MATRIX:
            raise InputError("a variable is no matrix", remedy="the file is damaged")
        return stop - start

    def leaves(self) -> Iterator[Leaf]:
        """Its content."""
        data = self._data(None)
        skip = 8 if self.compressed else 0
        if len(data) != skip + self.length():
            raise cut()
        return _leaves(Cursor(data, self.order, skip), None, 0)

    def _data(self, most: int | None) -> bytes:
        """Its first bytes, or all of them, unpacked, with checked checksum."""
        self.stream.seek(self.begin)
        there = self.end - self.begin
        if not self.compressed:
            return self.stream.read(there if most is None else min(most, there))
        unpacking = zlib.decompressobj()
        if most is not None:
            return unpacking.decompress(self.stream.read(min(there, most + _HEAD)), most)
        packed, length = self.stream.read(there), self.length()
        data = unpacking.decompress(packed, 8 + length)
        if unpacking.decompress(unpacking.unconsumed_tail, 1) or not unpacking.eof:
            raise cut()
        return data


@dataclass(frozen=True)
class _Head:
    """The head of a matrix: class, whether it has an imaginary part, shape, name."""

    kind: int
    is_complex: bool
    shape: tuple[int, ...]
    name: str


def _head(cursor: Cursor) -> _Head:
    if cursor.at == cursor.end:  # the form of an empty field
        return _Head(_CELL, False, (0, 0), "")
    flags = cursor.numbers()
    if flags.size < 1:
        raise cut()
    kind = int(flags[0]) & 0xFF
    shape = () if kind == _OPAQUE else tuple(int(extent) for extent in cursor.numbers())
    if min(shape, default=0) < 0 or len(shape) > _MOST_DIMENSIONS:
        raise InputError("an array has an impossible shape", value=shape, remedy="the file is damaged")
    return _Head(kind, bool(int(flags[0]) & _COMPLEX), shape, cursor.text())


def _leaves(cursor: Cursor, name: str | None, depth: int) -> Iterator[Leaf]:
    """The matrix at the cursor, or the content of its fields."""
    head = _head(cursor)
    name = head.name if name is None else name
    if depth > _DEEPEST:
        raise InputError(f"structs nest deeper than {_DEEPEST}", value=name, remedy="save plainer variables")
    if head.kind == _STRUCT and np.prod(head.shape, dtype=object) == 1:
        for field in _fields(cursor):
            kind, start, stop = cursor.element()
            if kind != _MATRIX:
                raise InputError("a field is no matrix", value=f"{name}.{field}", remedy="the file is damaged")
            yield from _leaves(Cursor(cursor.data, cursor.order, start, stop), f"{name}.{field}", depth + 1)
    elif head.kind == _CHAR:
        yield Leaf(name, "text", head.shape, cursor.text)
    elif head.kind in _NUMERIC and not head.is_complex:
        yield Leaf(name, "numbers", head.shape, lambda: _array(cursor, head, name))
    else:
        other = "complex numbers" if head.is_complex else _KINDS.get(head.kind, "a struct array")
        yield Leaf(name, other, (), str)


def _fields(cursor: Cursor) -> list[str]:
    """Names of a struct's fields."""
    width = cursor.numbers()
    kind, start, stop = cursor.element()
    size = int(width[0]) if width.size == 1 else 0
    if size < 1 or kind not in TEXTS or (stop - start) % size:
        raise InputError("the names of a struct's fields cannot be read", remedy="the file is damaged")
    raw = [cursor.data[at : at + size] for at in range(start, stop, size)]
    return [one.split(b"\0")[0].decode("latin-1") for one in raw]


def _array(cursor: Cursor, head: _Head, name: str) -> npt.NDArray[Any]:
    numbers = cursor.numbers()
    expected = np.prod(head.shape, dtype=object)
    if numbers.size != expected:
        problem = f"{numbers.size} numbers where the shape {head.shape} needs {expected}"
        raise InputError(problem, remedy="the file is damaged", channel=name)
    return numbers.reshape(head.shape, order="F")
