"""Pieces of HTML that several parts of the page are made of."""

from __future__ import annotations

import math
from collections.abc import Sequence
from html import escape

NOTHING, BEYOND = "0%", "55%"
"""Lengths of bars without a number: room is left for the words behind them."""


def section(title: str, body: str, name: str) -> str:
    """A part of the page.

    Args:
        title: its heading, plain text.
        body: HTML.
        name: by which the page's style and tests find it.
    """
    return f'<section id="{name}"><h2>{escape(title)}</h2>{body}</section>'


def table(heads: Sequence[str], rows: Sequence[Sequence[str]], *, numbers: Sequence[int] = (), name: str = "") -> str:
    """A table that scrolls by itself where it is wider than the page.

    Args:
        heads: of the columns, HTML.
        rows: their cells, HTML.
        numbers: columns that stand to the right.
        name: class of the table.
    """
    right = set(numbers)
    top = "".join(_cell("th", text, k in right) for k, text in enumerate(heads))
    body = "".join(f"<tr>{''.join(_cell('td', text, k in right) for k, text in enumerate(row))}</tr>" for row in rows)
    return f'<div class="wide"><table class="{name}"><tr>{top}</tr>{body}</table></div>'


def _cell(kind: str, text: str, number: bool) -> str:
    return f"<{kind}{' class=n' if number else ''}>{text}</{kind}>"


def folded(summary: str, body: str) -> str:
    """Something that opens on a click."""
    return f"<details><summary>{escape(summary)}</summary>{body}</details>"


def soft(text: str) -> str:
    """A paragraph of an explanation, plain text."""
    return f'<p class="soft">{escape(text).replace(" %", "&nbsp;%")}</p>'


def bar(value: float, scale: float, colour: str, text: str, mark: str = "") -> str:
    """A bar, its number behind it.

    Args:
        value: its length, of `scale`.
        scale: what fills the track.
        colour: a variable of the page's style.
        text: behind it.
        mark: HTML to be drawn over the track.
    """
    width = along(value, scale) if math.isfinite(value) else NOTHING if math.isnan(value) else BEYOND
    return (
        f'<div class="track">{mark}<div class="bar" style="width:{width};--colour:var(--{colour})"></div>'
        f'<span style="left:{width}">{escape(text)}</span></div>'
    )


def along(value: float, scale: float) -> str:
    """A place on a track; the last part of it is left for the number."""
    return f"{84.0 * min(max(value / scale, 0.0), 1.0):.2f}%"
