"""HTML tables that notebooks show for an object, and the public names that tab completion offers."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from flexdyn.io.html import engine

MOST_TABLE_ROWS = 20
"""Rows of a table; further ones are counted."""


class Public:
    """A class whose tab completion shows public names only."""

    def __dir__(self) -> list[str]:
        """Names without an underscore in front."""
        return sorted(name for name in super().__dir__() if not name.startswith("_"))


def card(title: str, facts: Mapping[str, Any], *tables: str, notes: Iterable[str] = ()) -> str:
    """HTML of an object: its title, a line for each fact, tables, notes; all content is escaped.

    Args:
        title: what it is.
        facts: name -> value; empty values are left out.
        tables: from `html_table`.
        notes: sentences.
    """
    shown = [(name, value) for name, value in facts.items() if value not in ("", None)]
    return _macro("card", title, shown, tables, notes)


def html_table(heads: Sequence[str], rows: Iterable[Sequence[Any]], most: int = MOST_TABLE_ROWS) -> str:
    """An HTML table; of many rows the first `most`."""
    listed = [[_text(cell) for cell in row] for row in rows]
    return _macro("table", heads, listed[:most], len(listed) - most) if listed else ""


def _macro(name: str, *given: Any) -> str:
    text: str = getattr(engine().get_template("io/notebook.html").module, name)(*given)
    return text


def _text(cell: Any) -> str:
    return f"{cell:.4g}" if isinstance(cell, float) else "-" if cell is None else str(cell)
