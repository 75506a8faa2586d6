"""Tables that fit the terminal: names and numbers are not broken, even if it is narrow."""

from __future__ import annotations

import textwrap
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

COLUMN_GAP = 2
"""Number of blanks between columns."""
Row = tuple[str, ...]


@dataclass(frozen=True)
class Sheet:
    """A table of texts, laid out when the width of the terminal is known.

    If it does not fit, texts are broken between words. If that is not enough, the first column, which names the row,
    gets a line of its own. If even that is not enough, each row is printed cell after cell.

    Attributes:
        title: above it.
        columns: heads; those with a line break have several lines.
        rows: cells, which may have several lines.
        right: heads of the columns with numbers, which are right-aligned and never broken.
        legend: meanings of symbols, printed below.
    """

    title: str
    columns: Row
    rows: tuple[Row, ...]
    right: frozenset[str] = frozenset()
    legend: Mapping[str, str] = field(default_factory=dict)

    def __rich_console__(self, console: Any, options: Any) -> Iterator[Any]:
        """The lines that rich prints."""
        from rich.text import Text

        for text in self.lines(options.max_width):
            yield Text(text, style="bold" if text == self.title else "", no_wrap=True, overflow="ignore", end="\n")

    def lines(self, width: int) -> list[str]:
        """The table as lines that are not longer than the width, if its words allow it.

        Args:
            width: of the terminal.
        """
        body = self._across(width) or self._below(width) or self._apart(width)
        told = "; ".join(f"{symbol}: {meaning}" for symbol, meaning in self.legend.items())
        return [self.title, "", *body, *_wrapped(told, width), ""]

    def _across(self, width: int) -> list[str]:
        """One line for each row; empty if it does not fit."""
        widths = self._widths(range(len(self.columns)), width)
        if widths is None:
            return []
        found = self._line(self.columns, widths, rule=True)
        return found + [line for row in self.rows for line in self._line(row, widths, rule=False)]

    def _below(self, width: int) -> list[str]:
        """The first cell of each row above the others; empty if these do not fit."""
        widths = self._widths(range(1, len(self.columns)), width - COLUMN_GAP)
        if widths is None or len(self.columns) < 3:
            return []
        found = [" " * COLUMN_GAP + line for line in self._line(self.columns, widths, rule=True, first=1)]
        for row in self.rows:
            found += _wrapped(row[0], width)
            found += [" " * COLUMN_GAP + line for line in self._line(row, widths, rule=False, first=1)]
        return found

    def _apart(self, width: int) -> list[str]:
        """Every row by itself: its name, then its cells, each with its head."""
        found = []
        for row in self.rows:
            found += _wrapped(row[0], width)
            cells = zip(self.columns[1:], row[1:], strict=True)
            pairs = [f"{' '.join(head.split())} {' '.join(cell.split())}".strip() for head, cell in cells if cell]
            found += [" " * COLUMN_GAP + line for line in _packed(pairs, width - COLUMN_GAP)]
        return found

    def _widths(self, which: Sequence[int], width: int) -> list[int] | None:
        """Widths of the columns, the widest made narrower until they fit; None if that would break words."""
        natural, least = [], []
        for k in which:
            cells = [row[k] for row in (self.columns, *self.rows)]
            longest = max(len(line) for cell in cells for line in cell.split("\n"))
            words = max((len(word) for cell in cells for word in cell.split()), default=0)
            natural.append(longest)
            least.append(longest if self.columns[k] in self.right else words)
        room = width - COLUMN_GAP * (len(natural) - 1)
        if sum(least) > room:
            return None
        while sum(natural) > room:
            spare = [wide - low for wide, low in zip(natural, least, strict=True)]
            place = max(range(len(natural)), key=lambda k: (spare[k] > 0, natural[k]))
            natural[place] -= 1
        return natural

    def _line(self, row: Row, widths: Sequence[int], *, rule: bool, first: int = 0) -> list[str]:
        """A row as lines; with a rule below the heads."""
        columns, cells = self.columns[first:], row[first:]
        pieces = [_cell(cell, wide) for cell, wide in zip(cells, widths, strict=True)]
        tall = max(len(piece) for piece in pieces)
        # Heads are aligned at the bottom, cells at the top.
        even = [[""] * (tall - len(piece)) + piece if rule else piece + [""] * (tall - len(piece)) for piece in pieces]
        found = []
        for k in range(tall):
            texts = [
                piece[k].rjust(wide) if head in self.right else piece[k].ljust(wide)
                for piece, wide, head in zip(even, widths, columns, strict=True)
            ]
            found.append((" " * COLUMN_GAP).join(texts).rstrip())
        if rule:
            found.append("\N{BOX DRAWINGS LIGHT HORIZONTAL}" * (sum(widths) + COLUMN_GAP * (len(widths) - 1)))
        return found


def _cell(text: str, width: int) -> list[str]:
    """Lines of a cell, broken between words; indentation of a line is kept."""
    found: list[str] = []
    for line in text.split("\n"):
        found += [line] if len(line) <= width else _wrapped(line, width)
    return found


def _wrapped(text: str, width: int) -> list[str]:
    return textwrap.wrap(text, max(1, width), break_long_words=False, break_on_hyphens=False)


def _packed(pieces: Sequence[str], width: int) -> list[str]:
    """Pieces with three blanks between them; a piece is not broken if it fits on a line."""
    found: list[str] = []
    for piece in pieces:
        if found and len(found[-1]) + 3 + len(piece) <= width:
            found[-1] += f"   {piece}"
        else:
            found += _wrapped(piece, width)
    return found
