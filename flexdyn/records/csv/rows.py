"""The lines of a CSV file as numbers, and the error of the first line that is not a row of numbers."""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from typing import NoReturn

from flexdyn.arrays import Array
from flexdyn.errors import InputError
from flexdyn.records.csv.dialect import Dialect, is_stamp

Block = tuple[int, list[str]]
"""Number of the first line (from 1), and whole lines."""


@dataclass(frozen=True)
class Header:
    """The properties of the rows, from the head of a file.

    Attributes:
        dialect: separator and form of numbers.
        width: number of cells in every row.
        names: of the columns, if they have any.
        wanted: column by its key in the table.
        first_row: line of the first sample, from 1.
        units: units in the names, by the key in the table.
        told: whether the layout gives the decimal sign.
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


def blocks_of_numbers(header: Header, blocks: Iterator[Block]) -> Iterator[Array]:
    """Yield numbers (rows, requested columns) block by block; blank lines are allowed only at the end of the file.

    Args:
        header: of the table.
        blocks: of lines behind it.

    Raises:
        InputError: a line is no row of numbers; the message names it and the channel.
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
    """Raise the error of the first line that is no row of numbers."""
    dialect, width = header.dialect, header.width
    bad = _first_bad(dialect, lines, width, header.columns)
    row, cells = number + bad, dialect.split(lines[bad])
    if not lines[bad].strip():
        raise _empty_line(row)
    if len(cells) != width:
        told = "header names" if header.columns is None else "first has"
        problem = f"line {row}: {len(cells)} cells where the {told} {width}"
        missing = header.names[len(cells)] if len(cells) < len(header.names) else None
        raise InputError(problem, remedy="one cell per channel", row=row, channel=missing)
    raise _bad_cell(header, row, cells)


def _bad_cell(header: Header, row: int, cells: list[str]) -> InputError:
    """The error of the first requested cell that is no number."""
    dialect = header.dialect
    asked = [cells[column] for column in header.wanted.values()]
    if dialect.stamps is not None:
        at = list(header.wanted.values()).index(dialect.stamps.column)
        name = list(header.wanted)[at]
        if not is_stamp(asked[at]):
            remedy = "the first row has a date and a time of day there, so every row needs one"
            problem = f"line {row}: no date and time of day"
            return InputError(problem, value=asked[at], remedy=remedy, row=row, channel=name)
        asked[at] = "0"
    at = _first_bad(replace(dialect, stamps=None), asked, 1, None)
    text, name = asked[at], list(header.wanted)[at]
    sign = {".": "point", ",": "comma"}[dialect.decimal]
    remedy = f"give a number with a decimal {sign}"
    if dialect.decimal == "." and "," in text:
        remedy += ", or say decimal: ',' in a channel map"
    return InputError(f"line {row}: not a number", value=text, remedy=remedy, row=row, channel=name)


def _first_bad(dialect: Dialect, items: list[str], width: int, columns: Sequence[int] | None) -> int:
    """Index of the first of `items` that cannot be parsed; the last one if each can be parsed by itself."""
    last = len(items) - 1
    return bisect_left(range(last), True, key=lambda k: dialect.parse(items[: k + 1], width, columns) is None)


def _empty_line(row: int) -> InputError:
    return InputError(f"line {row}: empty line between samples", row=row, remedy="remove it")
