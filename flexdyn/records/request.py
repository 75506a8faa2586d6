"""What a reader is asked for beyond the path: which columns, how the file is laid out, where to report progress."""

from __future__ import annotations

from collections.abc import Callable, Collection
from dataclasses import dataclass, field

from flexdyn.errors import InputError, did_you_mean


@dataclass(frozen=True)
class Layout:
    """How a file that follows no convention of ours is laid out; a channel map says so under ``source``.

    Attributes:
        names_line: line of a text file that holds the names, from 1; None finds it.
        first_line: line of a text file that the first sample stands on, from 1; None takes the one after the names.
        delimiter: between the cells of a text file; None finds it.
        decimal: decimal sign of a text file, ``.`` or ``,``; None finds it.
        encoding: of a text file, such as ``latin-1``; None takes UTF-8 or, where it is not that, Windows-1252.
        topic: of a bag; None takes the only one that can be read.
        merge: of a bag: how columns of other topics are put on common times, ``linear`` or ``hold``.
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
        columns: names (or, in text files, numbers from 1) of the columns wanted; None takes every one.
        layout: how the file is laid out.
        progress: called now and then with the share of the file that has been read, from 0 to 1.
        mapped: a channel map gives the columns their names; else they follow ``t``, ``<signal>.<joint>`` by themselves.
        named: columns that the map names, also where every column is wanted.
    """

    columns: frozenset[str | int] | None = None
    layout: Layout = field(default_factory=Layout)
    progress: Callable[[float], None] | None = None
    mapped: bool = False
    named: frozenset[str | int] = frozenset()

    def chosen(self, there: Collection[str]) -> list[str]:
        """The columns to be read of those that a file has, in the file's order.

        Raises:
            InputError: one that is wanted is not there.
        """
        for name in sorted((self.columns or frozenset()) - set(there), key=str):
            raise InputError("no such column", key=str(name), remedy=did_you_mean(str(name), there), channel=str(name))
        return [name for name in there if self.wants(name)]

    def wants(self, name: str) -> bool:
        """Whether a column of that name is to be read."""
        return self.columns is None or name in self.columns

    def report(self, share: float) -> None:
        """Say how far the reading is."""
        if self.progress is not None:
            self.progress(min(1.0, max(0.0, share)))
