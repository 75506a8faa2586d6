"""The request for a reader: the columns, the layout of the file, and where to report progress."""

from __future__ import annotations

from collections.abc import Callable, Collection
from dataclasses import dataclass, field

from flexdyn.checks import check_known

CLOCKS = ("message", "bag")
"""Where the times of a bag come from: the stamps in the messages, or the times of recording."""


@dataclass(frozen=True)
class Layout:
    """The layout of a file that does not follow our convention; a channel map gives it under ``source``.

    Attributes:
        names_line: line of the names in a text file, from 1; None finds it.
        first_line: line of the first sample in a text file, from 1; None takes the one after the names.
        delimiter: between the cells of a text file; None finds it.
        decimal: decimal sign of a text file, ``.`` or ``,``; None finds it.
        encoding: of a text file, such as ``latin-1``; None takes UTF-8 or, where it is not that, Windows-1252.
        topic: of a bag; None takes the only readable one.
        merge: of a bag: how columns of other topics are converted to common times, ``linear`` or ``hold``.
        clock: of a bag: ``message`` takes the stamp in the message's header, ``bag`` the time of recording.
    """

    names_line: int | None = None
    first_line: int | None = None
    delimiter: str | None = None
    decimal: str | None = None
    encoding: str | None = None
    topic: str | None = None
    clock: str = "message"
    merge: str = "linear"


@dataclass(frozen=True)
class Request:
    """What to read of a file.

    Attributes:
        columns: names (or, in text files, numbers from 1) of the requested columns; None takes all.
        layout: of the file.
        progress: called from time to time with the share of the file that has been read, from 0 to 1.
        mapped: whether a channel map gives the names; otherwise the file has ``t`` and ``<signal>.<joint>``.
        named: columns that the map names, also if all columns are requested.
    """

    columns: frozenset[str | int] | None = None
    layout: Layout = field(default_factory=Layout)
    progress: Callable[[float], None] | None = None
    mapped: bool = False
    named: frozenset[str | int] = frozenset()

    def chosen(self, there: Collection[str]) -> list[str]:
        """The columns to be read of those that a file has, in the file's order.

        Raises:
            InputError: a requested column does not exist.
        """
        for name in sorted(self.columns or (), key=str):
            check_known(name, there, "no such column", channel=str(name))
        return [name for name in there if self.wants(name)]

    def wants(self, name: str) -> bool:
        """Whether a column of that name is to be read."""
        return self.columns is None or name in self.columns

    def report(self, share: float) -> None:
        """Report the progress of the reading."""
        if self.progress is not None:
            self.progress(min(1.0, max(0.0, share)))
