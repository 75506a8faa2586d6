"""CSV: a header of channel names, then one line of numbers per sample."""

from __future__ import annotations

import csv
import os
from array import array
from collections.abc import Iterator
from itertools import chain
from pathlib import Path
from typing import TextIO

import numpy as np

from flexdyn.errors import InputError
from flexdyn.records.csv.guess import encoding_of
from flexdyn.records.csv.header import header_of
from flexdyn.records.csv.rows import Block, Header, blocks_of_numbers
from flexdyn.records.recording import Recording
from flexdyn.records.request import Request
from flexdyn.records.table import Rows, Table

_CSV_BLOCK = 2**20
_LONGEST_LINE = 2**20
_CSV_ROWS_AT_ONCE = 4096


def write(rec: Recording, path: Path, delimiter: str = ",") -> None:
    """Write the shortest digits that determine every double; a plain table has no meta data.

    Args:
        rec: the recording.
        path: of the new file.
        delimiter: between columns.
    """
    columns = [rec.t, *rec.channels.values()]
    with open(path, "x", encoding="utf-8", newline="\n") as stream:
        csv.writer(stream, delimiter=delimiter, lineterminator="\n").writerow(["t", *rec.channels])
        for start in range(0, len(rec), _CSV_ROWS_AT_ONCE):
            rows = zip(*(column[start : start + _CSV_ROWS_AT_ONCE].tolist() for column in columns), strict=True)
            stream.writelines(delimiter.join(map(repr, row)) + "\n" for row in rows)


def read(path: Path, request: Request) -> Table:
    """Read block by block: memory never holds the whole text, and the numbers at most one and a half times.

    A column that was requested by its number n is ``column n`` in the table; one requested by name has its name.

    Args:
        path: of the file.
        request: what is wanted, and how the file is laid out.

    Raises:
        InputError: with line and channel.
    """
    encoding, errors, guess = encoding_of(path, request.layout.encoding)
    with open(path, encoding=encoding, errors=errors) as stream:
        blocks = _blocks(stream, os.path.getsize(path), request)
        header, rest = header_of(blocks, request)
        columns = [array("d") for _ in header.wanted]  # they grow in place, without a second copy
        for numbers in blocks_of_numbers(header, chain([rest], blocks)):
            for column, values in zip(columns, numbers.T, strict=True):
                column.frombytes(values.tobytes())
    table = Table(rows=Rows("line", header.first_row), units=dict(header.units))
    table.said = [text for text in (guess, _guessed(header)) if text]
    if header.dialect.stamps is not None and header.dialect.stamps.start_ns is not None:
        table.meta["start_ns"] = header.dialect.stamps.start_ns
    for name, column in zip(header.wanted, columns, strict=True):
        table.add(name, np.frombuffer(column))
    return table


def _guessed(header: Header) -> str:
    """A note that the decimal sign was guessed, if it matters."""
    if header.told or header.dialect.decimal == ".":
        return ""
    return "numbers were read with a decimal comma; if that is wrong, say source: {decimal: .} in a channel map"


def _blocks(stream: TextIO, size: int, request: Request) -> Iterator[Block]:
    """Yield the file block by block, and report the progress."""
    number, rest = 1, ""
    while text := stream.read(_CSV_BLOCK):
        head, newline, rest = (rest + text).rpartition("\n")
        lines = head.split("\n") if newline else []
        if lines:
            yield number, lines
        number += len(lines)
        if len(rest) > _LONGEST_LINE:
            remedy = "is it a CSV file?"
            raise InputError(f"line {number}: longer than {_LONGEST_LINE} characters", remedy=remedy, row=number)
        request.report(stream.buffer.tell() / size)
    if rest:
        yield number, [rest]
