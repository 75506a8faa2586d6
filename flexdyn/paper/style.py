"""The style of the study's figures, and how they are saved."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from flexdyn.errors import needed
from flexdyn.io.files import replacing
from flexdyn.paper.cases import TORQUE_END
from flexdyn.paper.chapter import Figure

# Okabe and Ito's colours, which colour-blind readers can distinguish; each has its own line style for print.
BLUE, VERMILION, GREEN, PURPLE, ORANGE, SKY = "#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9"
BLACK, GREY = "#000000", "#8C8C8C"
DASHED, DOTTED = (0, (5, 2)), (0, (1, 1.2))
FLEXIBLE = {"color": BLUE, "linestyle": "-", "label": "flexible"}
RIGID = {"color": VERMILION, "linestyle": DASHED, "label": "rigid"}
STYLE = Path(__file__).with_name("figures.mplstyle")


def require_matplotlib() -> Any:
    """Import Matplotlib; if it is missing, the error says how to install it.

    Raises:
        MissingExtra: it is not installed.
    """
    with needed("matplotlib", "plot"):
        import matplotlib.figure
        import matplotlib.style
    return matplotlib


def save_figure(figure: Figure, folder: Path) -> list[Path]:
    """Draw a figure once and write it as PNG at 300 dpi and as PDF, each file completely or not at all."""
    matplotlib = require_matplotlib()
    paths = []
    with matplotlib.style.context(["default", STYLE]):
        canvas = matplotlib.figure.Figure(figsize=figure.size, layout="constrained")
        figure.draw(canvas)
        for kind, stamp in (("png", {"Software": None}), ("pdf", {"CreationDate": None})):
            path = folder / f"{figure.name}.{kind}"
            with replacing(path) as fresh:
                canvas.savefig(fresh, format=kind, metadata=stamp)
            canvas.set_layout_engine("none")  # the places that were found are those of both files
            paths.append(path)
    return paths


def titled(panel: Any, name: str, text: str) -> None:
    """Set the title of a panel: its letter and its content."""
    panel.set_title(f"({name})  {text}", loc="left")


def torque_on(panel: Any) -> None:
    """Shade the time during which the torque of Fig. 4 acts."""
    panel.axvspan(0.0, TORQUE_END, color="#EDEDED", linewidth=0, zorder=0)
