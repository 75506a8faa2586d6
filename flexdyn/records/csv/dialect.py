"""The separator of the cells of a CSV file and the form of its numbers; parsing of lines."""

from __future__ import annotations

import csv
import re
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from flexdyn.records.csv.stamps import Stamps
from flexdyn.records.table import FloatArray

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

    def parse(self, lines: list[str], width: int, columns: Sequence[int] | None = None) -> FloatArray | None:
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

    def _loaded(self, lines: list[str], columns: Sequence[int] | None) -> FloatArray | None:
        delimiter = None if self.delimiter == " " else self.delimiter
        converters: dict[int | str, Any] | None = (
            None if self.stamps is None else {self.stamps.column: self.stamps.seconds}
        )
        settings: dict[str, Any] = {"delimiter": delimiter, "comments": None, "ndmin": 2, "encoding": None}
        try:
            return np.asarray(np.loadtxt(lines, usecols=columns, converters=converters, **settings), dtype=np.float64)
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
