"""HTML tables that notebooks show for an object, and the public names that tab completion offers."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from html import escape
from typing import Any

MOST_TABLE_ROWS = 20
"""Rows of a table; further ones are counted."""
_CELL = 'style="text-align:left;padding:2px 12px 2px 0"'


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
        tables: from `table`.
        notes: sentences.
    """
    lines = [f"<b>{escape(title)}</b>"]
    lines += [f"{escape(name)}: {escape(str(value))}" for name, value in facts.items() if value not in ("", None)]
    below = "".join(f"<div>{escape(str(note))}</div>" for note in notes)
    return f"<div>{''.join(f'<div>{line}</div>' for line in lines)}{''.join(tables)}{below}</div>"


def table(heads: Sequence[str], rows: Iterable[Sequence[Any]], most: int = MOST_TABLE_ROWS) -> str:
    """An HTML table; of many rows the first `most`."""
    listed = [tuple(row) for row in rows]
    head = "".join(f"<th {_CELL}>{escape(text)}</th>" for text in heads)
    body = "".join(
        f"<tr>{''.join(f'<td {_CELL}>{escape(_text(cell))}</td>' for cell in row)}</tr>" for row in listed[:most]
    )
    more = f"<div>and {len(listed) - most} more</div>" if len(listed) > most else ""
    return f"<table><thead><tr>{head}</tr></thead><tbody>{body}</tbody></table>{more}" if listed else ""


def _text(cell: Any) -> str:
    return f"{cell:.4g}" if isinstance(cell, float) else str(cell)
