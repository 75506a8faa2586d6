"""Printing: tables for people, JSON for programs, notes beside both on stderr."""

from __future__ import annotations

import json
import math
import os
import sys
from collections.abc import Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from flexdyn.cli.sheet import Sheet
from flexdyn.errors import visible

if TYPE_CHECKING:
    from rich.console import Console

PIPE_WIDTH = 160


def console(*, stderr: bool = False) -> Console:
    """Where to print; a pipe or file is given wide lines, so that a table's rows stay whole."""
    from rich.console import Console

    stream = sys.stderr if stderr else sys.stdout
    width = None if stream.isatty() else int(os.environ.get("COLUMNS") or PIPE_WIDTH)
    return Console(stderr=stderr, width=width, markup=False, highlight=False, emoji=False)


def show(*parts: Any) -> None:
    """Print texts and tables on stdout, one below the other."""
    out = console()
    for part in parts:
        text = isinstance(part, str)
        out.print(visible(part, lines=True) if text else part, soft_wrap=text)  # a line to be copied stays one


def show_json(document: Any) -> None:
    """Print pure JSON on stdout; numbers that JSON does not have (infinite, NaN) are null."""
    text = json.dumps(plain(document), indent=2, ensure_ascii=False, allow_nan=False)
    safe = (letter if letter.isprintable() or letter == "\n" else json.dumps(letter)[1:-1] for letter in text)
    sys.stdout.write("".join(safe) + "\n")


def note(text: str) -> None:
    """One line on stderr that is worth knowing and no error."""
    console(stderr=True).print(f"flexdyn: {visible(text)}", soft_wrap=True)


def table(
    title: str,
    columns: Iterable[str],
    rows: Iterable[Sequence[Any]],
    *,
    right: Iterable[str] = (),
    legend: Mapping[str, str] | None = None,
) -> Sheet:
    """A table of texts that fits the terminal with its names and numbers whole.

    Args:
        title: above it.
        columns: their heads.
        rows: their cells, in order.
        right: heads of the columns that hold numbers and stand to the right.
        legend: what the symbols in it mean, printed below.
    """
    cells = tuple(tuple(visible(str(cell), lines=True) for cell in row) for row in rows)
    return Sheet(visible(title), tuple(columns), cells, frozenset(right), legend or {})


def number(value: float | None, digits: int = 4) -> str:
    """A number as a table shows it; a dash where there is none."""
    return "-" if value is None or math.isnan(value) else f"{value:.{digits}g}"


def plain(value: Any) -> Any:
    """Data as JSON can hold it."""
    if isinstance(value, Mapping):
        return {str(key): plain(entry) for key, entry in value.items()}
    if isinstance(value, np.ndarray):
        return plain(value.tolist())
    if isinstance(value, list | tuple):
        return [plain(entry) for entry in value]
    if isinstance(value, np.bool_ | np.integer | np.floating):
        return plain(value.item())
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    if value is None or isinstance(value, bool | int | str):
        return value
    return str(value)
