"""The lines of a CSV file as numbers, and what is wrong with the first line that is none."""

from __future__ import annotations

import csv
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import NoReturn

import numpy as np

from flexdyn.errors import InputError
from flexdyn.records.table import FloatArray

Block = tuple[int, list[str]]
"""Number of the first line (from 1), and whole lines."""


@dataclass(frozen=True)
class Dialect:
    """What separates the cells, a space standing for any white space, and the decimal sign."""

    delimiter: str
    decimal: str = "."

    def split(self, line: str) -> list[str]:
        """The cells of a line without the quotes and spaces round them."""
        if '"' in line:
            try:
                reader = csv.reader([line], delimiter=self.delimiter, skipinitialspace=True)
                return [cell.strip() for cell in next(reader)]
            except csv.Error:
                pass  # a lone carriage return or an endless cell: the quotes stay
        return line.split() if self.delimiter == " " else [cell.strip() for cell in line.split(self.delimiter)]

    def plain(self, lines: list[str]) -> list[str]:
        """The lines without quotes, with decimal points; a delimiter within quotes gives way."""
        if '"' in "".join(lines):
            lines = [self._without_quotes(line) if '"' in line else line for line in lines]
        return lines if self.decimal == "." else [line.replace(self.decimal, ".") for line in lines]

    def _without_quotes(self, line: str) -> str:
        cells = [cell.replace(self.decimal, ".").replace(self.delimiter, "_") for cell in self.split(line)]
        return self.delimiter.join(cells)

    def width(self, line: str) -> int:
        """Number of cells of a line without quotes."""
        return len(line.split()) if self.delimiter == " " else line.count(self.delimiter) + 1

    def parse(self, lines: list[str], width: int, columns: Sequence[int] | None = None) -> FloatArray | None:
        """Numbers (lines, columns), all columns by default; None if any line lacks them or has not `width` cells."""
        lines = self.plain(lines)
        if not all(map(str.strip, lines)):  # loadtxt would skip an empty one, and warn where nothing is left
            return None
        if columns is not None and any(self.width(line) != width for line in lines):
            return None
        delimiter = None if self.delimiter == " " else self.delimiter
        try:
            block = np.loadtxt(lines, delimiter=delimiter, comments=None, ndmin=2, usecols=columns)
        except ValueError:
            return None
        return block if block.shape == (len(lines), width if columns is None else len(columns)) else None


@dataclass(frozen=True)
class Header:
    """What the head of a file tells about its rows.

    Attributes:
        dialect: what the cells are separated by.
        width: number of cells in every row.
        names: of the columns, as far as they have some.
        wanted: column by the key that it gets in the table.
        first_row: line that the first sample stands on, from 1.
    """

    dialect: Dialect
    width: int
    names: tuple[str, ...]
    wanted: dict[str, int]
    first_row: int

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
    asked = [cells[column] for column in header.wanted.values()]
    at = _first_bad(dialect, asked, 1, None)
    text, name = asked[at], list(header.wanted)[at]
    problem = f"line {row}: {'not a number' if text else 'empty cell'}"
    sign = {".": "point", ",": "comma"}[dialect.decimal]
    remedy = f"give a number with a decimal {sign}"
    if dialect.decimal == "." and "," in text:
        remedy += ", or say decimal: ',' in a channel map"
    raise InputError(problem, key=name, value=text or None, remedy=remedy, row=row, channel=name)


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
