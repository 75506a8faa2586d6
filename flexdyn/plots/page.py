"""Parts that all pictures share: formats, colours, axes, saving."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from flexdyn.errors import needed
from flexdyn.io.files import check_suffix, replacing

SUFFIXES = (".png", ".pdf", ".svg")
"""Formats of pictures."""
BLUE, RED, GREY, PALE = "#1f4e9c", "#c23b22", "#6b7280", "#dbe4f3"
SHADES = ("#7f1d1d", "#d97757", GREY, "#6ea0dc", BLUE)
"""Colours of five curves, from the smallest to the largest."""
GUIDE_DASHES = (0, (3, 3))
GUIDE: dict[str, Any] = {"color": GREY, "linewidth": 1.4, "linestyle": GUIDE_DASHES}
"""Look of what was asked for, and of the true value."""
LAW_LINE_WIDTH = 2.2
"""Width of a law's line [pt]."""


def checked_path(path: str | Path, suffixes: Sequence[str] = SUFFIXES) -> Path:
    """The path of a picture.

    Raises:
        InputError: its suffix is none of those.
    """
    file = Path(path)
    check_suffix(file, suffixes, "a picture")
    return file


def new_figure() -> Any:
    """An empty figure of the common size.

    Raises:
        MissingExtra: matplotlib is not installed.
    """
    with needed("matplotlib", "plot"):
        from matplotlib.figure import Figure
    return Figure(figsize=(6.4, 4.4))


def dress(axes: Any, across: str, up: str) -> None:
    """Set labels with units and a grid."""
    axes.set_xlabel(across)
    axes.set_ylabel(up)
    axes.grid(color="#e5e7eb", linewidth=0.7)
    axes.set_axisbelow(True)
    axes.locator_params(axis="x", nbins=7)
    axes.spines[["top", "right"]].set_visible(False)


def cross(axes: Any) -> None:
    """Lines through the origin."""
    axes.axhline(0.0, color="#111827", linewidth=0.7, zorder=1.0)
    axes.axvline(0.0, color="#111827", linewidth=0.7, zorder=1.0)


def line(axes: Any, x: Any, y: Any, color: str | tuple[float, ...] = BLUE, **look: Any) -> None:
    """The line of a law."""
    axes.plot(x, y, color=color, linewidth=LAW_LINE_WIDTH, **look)


def against_identity(axes: Any, x: Any, plain: str, law: Any, label: str) -> None:
    """A law beside y = x, which is dashed, with a legend of both."""
    axes.plot(x, x, color=GREY, linewidth=1.0, linestyle=GUIDE_DASHES, label=plain)
    line(axes, x, law, label=label)
    axes.legend(frameon=False, loc="upper left")


def legend(axes: Any, title: str, *, upside_down: bool = False) -> None:
    """A legend to the right of the axes, which become narrower.

    Args:
        axes: with the labelled curves.
        title: above it.
        upside_down: whether the last curve comes first, because it is the uppermost.
    """
    handles, labels = axes.get_legend_handles_labels()
    order = slice(None, None, -1 if upside_down else 1)
    axes.legend(handles[order], labels[order], title=title, frameon=False, loc="center left", bbox_to_anchor=(1.0, 0.5))
    axes.set_position((0.13, 0.13, 0.62, 0.68))


def legend_above(axes: Any, columns: int) -> None:
    """A legend of one line above the axes, which become lower."""
    axes.legend(frameon=False, loc="lower left", bbox_to_anchor=(0.0, 0.99), ncols=columns, fontsize=8.5, borderpad=0.1)
    axes.set_position((0.13, 0.13, 0.83, 0.63))


def save_picture(figure: Any, file: Path) -> None:
    """Write the picture completely or not at all."""
    with replacing(file) as fresh:
        figure.savefig(fresh, format=file.suffix.lower()[1:], dpi=200)
