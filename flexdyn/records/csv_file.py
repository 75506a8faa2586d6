"""CSV: a header of channel names, then one line of numbers per sample."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import chain
from pathlib import Path
from typing import TYPE_CHECKING, NoReturn, TextIO

import numpy as np

from flexdyn.errors import InputError
from flexdyn.records.request import Request
from flexdyn.records.table import FloatArray, Rows, Table, check_name, check_time_named

if TYPE_CHECKING:
    from flexdyn.records.recording import Recording

_DELIMITERS = (",", ";", "\t")
_BLOCK = 2**20
_LONGEST_LINE = 2**20
_ROWS_AT_ONCE = 4096

_Block = tuple[int, list[str]]
"""Number of the first line (from 1), and whole lines."""


@dataclass(frozen=True)
class _Header:
    """Names of the columns, what separates them, and the line that the first sample stands on."""

    names: tuple[str, ...]
    delimiter: str
    first_row: int


def write(rec: Recording, path: Path) -> None:
    """Write the shortest digits that give every double back; meta has no place in a plain table."""
    columns = [rec.t, *rec.channels.values()]
    with open(path, "x", encoding="utf-8", newline="\n") as stream:
        stream.write(",".join(["t", *rec.channels]) + "\n")
        for start in range(0, len(rec), _ROWS_AT_ONCE):
            rows = zip(*(column[start : start + _ROWS_AT_ONCE].tolist() for column in columns), strict=True)
            stream.writelines(",".join(map(repr, row)) + "\n" for row in rows)


def read(path: Path, request: Request) -> Table:
    """Read block by block: the text is never held whole, the numbers at most twice.

    Raises:
        InputError: with line and channel.
    """
    # Undecodable bytes become surrogates, which no name may hold and no number parses.
    with open(path, encoding="utf-8-sig", errors="surrogateescape") as stream:
        blocks = _blocks(stream)
        header, rest = _header(blocks)
        parsed = list(_parsed(header, chain([rest], blocks)))
    table = Table(rows=Rows("line", header.first_row))
    for column, name in enumerate(header.names):
        table.add(name, np.concatenate([block[:, column] for block in parsed]) if parsed else np.empty(0))
    return table


def _blocks(stream: TextIO) -> Iterator[_Block]:
    """The file block by block, none held longer than its turn."""
    number, rest = 1, ""
    while text := stream.read(_BLOCK):
        head, newline, rest = (rest + text).rpartition("\n")
        lines = head.split("\n") if newline else []
        if lines:
            yield number, lines
        number += len(lines)
        if len(rest) > _LONGEST_LINE:
            raise InputError(
                f"line {number}: longer than {_LONGEST_LINE} characters", remedy="is it a CSV file?", row=number
            )
    if rest:
        yield number, [rest]


def _header(blocks: Iterator[_Block]) -> tuple[_Header, _Block]:
    """The header, and what follows it in its block."""
    comment: tuple[int, str] | None = None
    for number, lines in blocks:
        for offset, line in enumerate(lines):
            if line.lstrip().startswith("#"):
                comment = (number + offset, line.strip().lstrip("#"))
            elif line.strip():
                return _header_from(line, comment, (number + offset, lines[offset:]))
    raise InputError("the file is empty", remedy="begin with a header t,q.<joint>,...")


def _header_from(line: str, comment: tuple[int, str] | None, here: _Block) -> tuple[_Header, _Block]:
    """The header from the first line that is no comment; if that is numbers, from the comment above (numpy.savetxt)."""
    number, lines = here
    at, text, skip = number, line, 1
    delimiter = _delimiter(line)
    if _parse([line], delimiter, line.count(delimiter) + 1) is not None:
        if comment is None:
            raise InputError(f"line {number}: no header", row=number, remedy="begin with a header t,q.<joint>,...")
        (at, text), skip = comment, 0
    delimiter = _delimiter(text)
    names = tuple(name.strip() for name in text.split(delimiter))
    try:
        _check_names(names)
    except InputError as error:
        raise InputError(f"line {at}: {error.problem}", **{**error.data, "row": at}) from None
    return _Header(names, delimiter, number + skip), (number + skip, lines[skip:])


def _check_names(names: tuple[str, ...]) -> None:
    seen: set[str] = set()
    for name in names:
        if name != "t":
            check_name(name)
        if name in seen:
            raise InputError("the channel is there twice", key=name, remedy="rename or remove one", channel=name)
        seen.add(name)
    check_time_named(names)


def _delimiter(line: str) -> str:
    """The separator that sets a column t apart; without one, the commonest."""
    for delimiter in _DELIMITERS:
        if "t" in (cell.strip() for cell in line.split(delimiter)):
            return delimiter
    return max(_DELIMITERS, key=line.count)


def _parsed(header: _Header, blocks: Iterator[_Block]) -> Iterator[FloatArray]:
    """Blocks of numbers (rows, columns); blank lines may only end the file."""
    blank = 0
    for number, lines in blocks:
        kept = len(lines)
        while kept and not lines[kept - 1].strip():
            kept -= 1
        if kept and blank:
            raise _empty_line(blank)
        if kept < len(lines):
            blank = blank or number + kept
        if kept:
            yield _numbers(header, number, lines[:kept])


def _numbers(header: _Header, number: int, lines: list[str]) -> FloatArray:
    block = _parse(lines, header.delimiter, len(header.names))
    if block is None:
        _explain(header, number, lines)
    return block


def _parse(lines: list[str], delimiter: str, width: int) -> FloatArray | None:
    """Numbers (lines, width), or None if any line is not a row of `width` numbers."""
    if "" in lines:  # loadtxt would skip it, and warn where nothing is left
        return None
    try:
        block = np.loadtxt(lines, delimiter=delimiter, comments=None, ndmin=2)
    except ValueError:
        return None
    return block if block.shape == (len(lines), width) else None


def _explain(header: _Header, number: int, lines: list[str]) -> NoReturn:
    """Raise what is wrong with the first line that is no row of numbers."""
    names, delimiter = header.names, header.delimiter
    bad = _first_bad(lines, delimiter, len(names))
    row, cells = number + bad, lines[bad].split(delimiter)
    if not lines[bad].strip():
        raise _empty_line(row)
    if len(cells) != len(names):
        problem = f"line {row}: {len(cells)} cells where the header names {len(names)}"
        missing = names[len(cells)] if len(cells) < len(names) else None
        raise InputError(problem, key=missing, remedy="one cell per channel", row=row, channel=missing)
    column = _first_bad(cells, delimiter, 1)
    text, name = cells[column].strip(), names[column]
    problem = f"line {row}: {'not a number' if text else 'empty cell'}"
    remedy = "give a number with a decimal point"
    raise InputError(problem, key=name, value=text or None, remedy=remedy, row=row, channel=name)


def _first_bad(items: list[str], delimiter: str, width: int) -> int:
    """Index of the first of `items` that does not parse, by halving: some item is known to be bad."""
    low, high = 0, len(items)
    while high - low > 1:
        middle = (low + high) // 2
        if _parse(items[low:middle], delimiter, width) is None:
            high = middle
        else:
            low = middle
    return low


def _empty_line(row: int) -> InputError:
    return InputError(f"line {row}: empty line between samples", row=row, remedy="remove it")
