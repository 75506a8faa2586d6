"""Printing: tables for people, JSON for programs, notes on stderr."""

from __future__ import annotations

import json
import math
import os
import sys
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

from flexdyn.cli.sheet import Sheet
from flexdyn.errors import visible
from flexdyn.io.json_text import json_text

if TYPE_CHECKING:
    from rich.console import Console

PIPE_WIDTH = 160


def console(*, stderr: bool = False) -> Console:
    """The console; in a pipe or file lines are wide, so that rows of a table are not broken."""
    from rich.console import Console

    stream = sys.stderr if stderr else sys.stdout
    width = None if stream.isatty() else int(os.environ.get("COLUMNS") or PIPE_WIDTH)
    return Console(stderr=stderr, width=width, markup=False, highlight=False, emoji=False)


@contextmanager
def progress(first: str, line: Callable[[Any], str] = str) -> Iterator[Callable[[Any], None] | None]:
    """Keep a line on stderr up to date if that is a terminal; else None.

    Args:
        first: the line until something is reported.
        line: the line for what is reported.
    """
    err = console(stderr=True)
    if not err.is_terminal:
        yield None
        return
    with err.status(first) as status:
        yield lambda reached: status.update(line(reached))


def show(*parts: Any) -> None:
    """Print texts and tables on stdout, one below the other; None is left out."""
    out = console()
    for part in (part for part in parts if part is not None):
        text = isinstance(part, str)
        out.print(visible(part, lines=True) if text else part, soft_wrap=text)  # a line to be copied is not broken


def show_json(document: Any) -> None:
    """Print pure JSON on stdout; numbers that JSON does not have (infinite, NaN) are null."""
    text = json_text(document)
    safe = (letter if letter.isprintable() or letter == "\n" else json.dumps(letter)[1:-1] for letter in text)
    sys.stdout.write("".join(safe) + "\n")


def answer(found: Any, report: Callable[[Any], Iterable[Any]], as_json: bool, drawn: Path | None = None) -> None:
    """Print a result: as JSON, or the texts and tables of its report, and the path of its picture."""
    if as_json:
        show_json(found.to_dict())
    else:
        show(*report(found), None if drawn is None else f"drawn in {drawn}")


def note(text: str) -> None:
    """Print a note, which is no error, as one line on stderr."""
    console(stderr=True).print(f"flexdyn: {visible(text)}", soft_wrap=True)


def table(
    title: str,
    columns: Iterable[str],
    rows: Iterable[Sequence[Any]],
    *,
    right: Iterable[str] = (),
    legend: Mapping[str, str] | None = None,
) -> Sheet:
    """A table of texts that fits the terminal without breaking names and numbers.

    Args:
        title: above it.
        columns: their heads.
        rows: their cells, in order.
        right: heads of the columns with numbers, which are right-aligned.
        legend: meanings of its symbols, printed below.
    """
    cells = tuple(tuple(visible(str(cell), lines=True) for cell in row) for row in rows)
    heads, numbers = (map(visible, names) for names in (columns, right))  # a head may be the name of a file
    return Sheet(visible(title), tuple(heads), cells, frozenset(numbers), legend or {})


def cell(value: float | None, digits: int = 4) -> str:
    """A number for a table; a dash if there is none."""
    return "-" if value is None or math.isnan(value) else f"{value:.{digits}g}"
