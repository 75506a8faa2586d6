"""The lines of a CSV file as numbers, and what is wrong with the first line that is none."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from typing import NoReturn

from flexdyn.errors import InputError
from flexdyn.records.csv.dialect import Dialect
from flexdyn.records.csv.stamps import is_stamp
from flexdyn.records.table import FloatArray

Block = tuple[int, list[str]]
"""Number of the first line (from 1), and whole lines."""


@dataclass(frozen=True)
class Header:
    """What the head of a file tells about its rows.

    Attributes:
        dialect: what the cells are separated by.
        width: number of cells in every row.
        names: of the columns, as far as they have some.
        wanted: column by the key that it gets in the table.
        first_row: line that the first sample stands on, from 1.
        units: that names state, by the key in the table.
        told: whether the layout says what the decimal sign is.
    """

    dialect: Dialect
    width: int
    names: tuple[str, ...]
    wanted: dict[str, int]
    first_row: int
    units: dict[str, str] = field(default_factory=dict)
    told: bool = False

    @property
    def columns(self) -> list[int] | None:
        """Columns to be read; None for all in order."""
        columns = list(self.wanted.values())
        return None if columns == list(range(self.width)) else columns


def blocks_of_numbers(header: Header, blocks: Iterator[Block]) -> Iterator[FloatArray]:
    """Numbers (rows, wanted columns) block by block; blank lines may only end the file.

    Raises:
        InputError: a line is no row of numbers; it is named with the channel.
    """
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
            block = header.dialect.parse(lines[:kept], header.width, header.columns)
            if block is None:
                _explain(header, number, lines[:kept])
            yield block


def _explain(header: Header, number: int, lines: list[str]) -> NoReturn:
    """Raise what is wrong with the first line that is no row of numbers."""
    dialect, width = header.dialect, header.width
    bad = _first_bad(dialect, lines, width, header.columns)
    row, cells = number + bad, dialect.split(lines[bad])
    if not lines[bad].strip():
        raise _empty_line(row)
    if len(cells) != width:
        told = "header names" if header.columns is None else "first has"
        problem = f"line {row}: {len(cells)} cells where the {told} {width}"
        missing = header.names[len(cells)] if len(cells) < len(header.names) else None
        raise InputError(problem, key=missing, remedy="one cell per channel", row=row, channel=missing)
    raise _bad_cell(header, row, cells)


def _bad_cell(header: Header, row: int, cells: list[str]) -> InputError:
    """What is wrong with the first cell wanted that is no number."""
    dialect = header.dialect
    asked = [cells[column] for column in header.wanted.values()]
    if dialect.stamps is not None:
        at = list(header.wanted.values()).index(dialect.stamps.column)
        name = list(header.wanted)[at]
        if not is_stamp(asked[at]):
            remedy = "the first row has a date and a time of day there, so every row needs one"
            problem = f"line {row}: no date and time of day"
            return InputError(problem, key=name, value=asked[at], remedy=remedy, row=row, channel=name)
        asked[at] = "0"
    at = _first_bad(replace(dialect, stamps=None), asked, 1, None)
    text, name = asked[at], list(header.wanted)[at]
    sign = {".": "point", ",": "comma"}[dialect.decimal]
    remedy = f"give a number with a decimal {sign}"
    if dialect.decimal == "." and "," in text:
        remedy += ", or say decimal: ',' in a channel map"
    return InputError(f"line {row}: not a number", key=name, value=text, remedy=remedy, row=row, channel=name)


def _first_bad(dialect: Dialect, items: list[str], width: int, columns: Sequence[int] | None) -> int:
    """Index of the first of `items` that does not parse, by halving: some item is known to be bad."""
    low, high = 0, len(items)
    while high - low > 1:
        middle = (low + high) // 2
        if dialect.parse(items[low:middle], width, columns) is None:
            high = middle
        else:
            low = middle
    return low


def _empty_line(row: int) -> InputError:
    return InputError(f"line {row}: empty line between samples", row=row, remedy="remove it")
