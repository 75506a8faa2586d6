"""The places of panels on the page: rows and columns in inches, so that nothing overlaps in any renderer."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

from flexdyn.plots.panel import Box, Key, Panel
from flexdyn.plots.picture import KEY, LEFT, Picture

RIGHT, TITLE, GAP, AXIS = 0.14, 0.34, 0.12, 0.52
"""Margins of a panel: right, above, below without and below with a horizontal axis [inch]."""
GUTTER = 2.35
"""Right margin of a panel with its own legend [inch]."""


@dataclass(frozen=True)
class Block:
    """Rows of panels over the full width of the page.

    Attributes:
        rows: panels from left to right; None leaves a place empty.
        heights: of the axes in each row [inch].
        width: of the axes of each panel [inch]; None: as wide as the page allows.
        left: left margin of the axes: space for names beside bars [inch].
    """

    rows: tuple[tuple[Panel | None, ...], ...]
    heights: tuple[float, ...]
    width: float | None = None
    left: float = LEFT

    @property
    def columns(self) -> int:
        """Panels side by side."""
        return max(len(row) for row in self.rows)

    @property
    def needs(self) -> float:
        """Width of the page that it needs [inch]."""
        return 0.0 if self.width is None else self.columns * (self.left + self.width + RIGHT) + RIGHT

    def inside(self, page: float) -> float:
        """Width of the axes of each of its panels on a page [inch]."""
        gutter = GUTTER if any(panel is not None and panel.legend for row in self.rows for panel in row) else 0.0
        return (page - RIGHT - gutter) / self.columns - self.left - RIGHT


def arrange(title: str, notes: Sequence[str], keys: Sequence[Key], blocks: Sequence[Block]) -> Picture:
    """A page of blocks, one below the other.

    Args:
        title: of the page.
        notes: sentences under it.
        keys: of the legend that panels share.
        blocks: from top to bottom.
    """
    width = max(7.4, *(block.needs for block in blocks))
    page = Picture(title, tuple(notes), (), tuple(keys), width, 0.0)
    head = page.legend_at + KEY * -(-len(keys) // page.legend_columns) + 0.05
    below = [(block, row, height) for block in blocks for row, height in zip(block.rows, block.heights, strict=True)]
    total = head + sum(TITLE + height + _foot(row) for _, row, height in below) + 0.05
    placed, top = [], total - head
    for block, row, height in below:
        inside, top = block.inside(width), top - TITLE - height
        for column, panel in enumerate(row):
            left = block.left + column * (block.left + inside + RIGHT)
            if panel is not None:
                placed.append(replace(panel, box=Box(left, top, inside, height)))
        top -= _foot(row)
    return replace(page, panels=tuple(placed), height=total)


def _foot(row: Sequence[Panel | None]) -> float:
    return AXIS if any(panel is not None and panel.labelled for panel in row) else GAP
