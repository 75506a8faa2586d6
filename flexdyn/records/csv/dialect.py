"""The separator of the cells of a CSV file, the form of its numbers and of its dates; parsing of lines."""

from __future__ import annotations

import csv
import math
import re
from collections.abc import Sequence
from dataclasses import dataclass, field
from datetime import UTC, datetime
from typing import Any

import numpy as np

from flexdyn.arrays import Array

_STAMP = re.compile(
    r"(?:(?P<iso>\d{4}-\d\d-\d\d)|(?P<day>\d\d)\.(?P<month>\d\d)\.(?P<year>\d{4}))"
    r"[T ](?P<clock>\d\d:\d\d:\d\d)(?:[.,](?P<part>\d{1,9}))?\s?(?P<zone>Z|[+-]\d\d:?\d\d)?"
)
"""ISO 8601 (2024-05-03T12:00:00.123+02:00, a space for the T as pandas writes it) and 03.05.2024 12:00:00,123."""


def is_stamp(cell: str) -> bool:
    """Whether the cell holds a date with a time of day."""
    return _STAMP.fullmatch(cell.strip().strip('"')) is not None


@dataclass
class Stamps:
    """Reads one column of stamps, row by row; stamps without a time zone are taken as UTC.

    Attributes:
        column: of the file, from 0.
        start_ns: of the first stamp that was read, in ns since 1970; None before.
    """

    column: int
    start_ns: int | None = None
    _known: dict[tuple[str, str], int] = field(default_factory=dict, repr=False)

    def seconds(self, cell: str) -> float:
        """Seconds from the first stamp read to this one, exact to the nanosecond.

        Raises:
            ValueError: it is no stamp.
        """
        text = cell.strip()
        match = _STAMP.fullmatch(text)
        if match is None and text.lower() != "nan":
            raise ValueError(text)
        if match is None:
            return math.nan
        day = match["iso"] or f"{match['year']}-{match['month']}-{match['day']}"
        stamp = self._second(f"{day}T{match['clock']}", match["zone"] or "") * 10**9
        stamp += int((match["part"] or "0").ljust(9, "0"))
        if self.start_ns is None:
            self.start_ns = stamp
        return (stamp - self.start_ns) / 1e9

    def _second(self, whole: str, zone: str) -> int:
        """Whole seconds since 1970; the last result is kept, because samples of one second follow each other."""
        key = (whole, zone)
        if key not in self._known:
            made = datetime.fromisoformat(whole + zone)
            self._known = {key: int((made if made.tzinfo else made.replace(tzinfo=UTC)).timestamp())}
        return self._known[key]


NOTHING = r"(?:|NA|N/A|#N/A|null|NULL|None)"
"""Contents of a cell without a number, as written by pandas, R, Excel and databases; ``nan`` is a number already."""


@dataclass(frozen=True)
class Dialect:
    """How lines are read.

    Attributes:
        delimiter: between the cells; a space means any white space.
        decimal: decimal sign.
        stamps: reader of the column of dates and times, if there is one.
    """

    delimiter: str
    decimal: str = "."
    stamps: Stamps | None = None

    def split(self, line: str) -> list[str]:
        """The cells of a line without surrounding quotes and spaces."""
        if '"' in line:
            try:
                reader = csv.reader([line], delimiter=self.delimiter, skipinitialspace=True)
                return [cell.strip() for cell in next(reader)]
            except csv.Error:
                pass  # a lone carriage return or an endless cell: the quotes stay
        return line.split() if self.delimiter == " " else [cell.strip() for cell in line.split(self.delimiter)]

    def plain(self, lines: list[str]) -> list[str]:
        """The lines without quotes, with decimal points; a delimiter within quotes is replaced."""
        if '"' in "".join(lines):
            lines = [self._without_quotes(line) if '"' in line else line for line in lines]
        return lines if self.decimal == "." else [line.replace(self.decimal, ".") for line in lines]

    def _without_quotes(self, line: str) -> str:
        cells = [cell.replace(self.decimal, ".").replace(self.delimiter, "_") for cell in self.split(line)]
        return self.delimiter.join(cells)

    def width(self, line: str) -> int:
        """Number of cells of a line without quotes."""
        return len(line.split()) if self.delimiter == " " else line.count(self.delimiter) + 1

    def blank(self, line: str) -> bool:
        """Whether all cells are empty, as in the rows of separators that spreadsheets write."""
        return not line.strip().strip(self.delimiter + " \t")

    def parse(self, lines: list[str], width: int, columns: Sequence[int] | None = None) -> Array | None:
        """Numbers (lines, columns), all columns by default, NaN for an empty cell.

        Returns:
            The numbers; None if another cell is no number, or a line has not `width` cells.
        """
        lines = self.plain(lines)
        if not all(map(str.strip, lines)):  # loadtxt would skip an empty line, and warn if no line is left
            return None
        if columns is not None and any(self.width(line) != width for line in lines):
            return None
        block = self._loaded(lines, columns)
        if block is None and (filled := self._filled(lines)) is not None:
            block = self._loaded(filled, columns)
        return block if block is None or block.shape == (len(lines), len(columns or ()) or width) else None

    def _loaded(self, lines: list[str], columns: Sequence[int] | None) -> Array | None:
        """Numbers by NumPy (rows, columns); None if a cell is none."""
        delimiter = None if self.delimiter == " " else self.delimiter
        settings: dict[str, Any] = {"delimiter": delimiter, "comments": None, "ndmin": 2, "encoding": None}
        if self.stamps is not None:
            settings["converters"] = {self.stamps.column: self.stamps.seconds}
        try:
            return np.asarray(np.loadtxt(lines, usecols=columns, **settings), dtype=np.float64)
        except ValueError:
            return None

    def _filled(self, lines: list[str]) -> list[str] | None:
        """The lines with nan in empty cells; None if there are none."""
        if self.delimiter == " ":
            pattern = rf"(?<!\S){NOTHING}(?!\S)".replace("(?:|", "(?:")
        else:
            mark = re.escape(self.delimiter)
            pattern = rf"(?:(?<={mark})|^)[ \t\r]*{NOTHING}[ \t\r]*(?={mark}|$)"
            pattern = pattern.replace(r"\t", "") if self.delimiter == "\t" else pattern
        gap = re.compile(pattern)
        filled = [gap.sub("nan", line) for line in lines]
        return filled if filled != lines else None
