"""A picture drawn by Matplotlib: .png, .pdf, .svg."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from flexdyn.errors import needed
from flexdyn.io.files import replacing
from flexdyn.plots.palette import INK, RULE, SOFT
from flexdyn.plots.panel import Curve, Key, Panel
from flexdyn.plots.picture import KEY, LEFT, Picture

STYLES: dict[str, Any] = {
    "solid": "-",
    "dashed": (0, (4.5, 1.8)),
    "dashdot": (0, (5, 1.5, 1, 1.5)),
    "dotted": (0, (1, 1.2)),
}
SETTINGS = {
    "font.size": 8.5,
    "axes.titlesize": 9.0,
    "axes.labelsize": 8.5,
    "xtick.labelsize": 8.0,
    "ytick.labelsize": 8.0,
    "axes.linewidth": 0.7,
    "axes.unicode_minus": True,
    "pdf.fonttype": 42,
}

LEGEND_LOOK = {"frameon": False, "borderpad": 0.0, "borderaxespad": 0.0, "handlelength": 2.6, "labelcolor": INK}


def write_picture(picture: Picture, file: Path) -> None:
    """Write the picture completely or not at all; the same picture gives the same bytes.

    Raises:
        InputError: the file cannot be written.
        MissingExtra: matplotlib is not installed.
    """
    figure = draw(picture)
    kind = file.suffix.lower()[1:]
    stamp = {"png": {"Software": None}, "pdf": {"CreationDate": None}, "svg": {"Date": None}}[kind]
    import matplotlib

    with matplotlib.rc_context({"svg.hashsalt": "flexdyn", "svg.fonttype": "none"}), replacing(file) as fresh:
        figure.savefig(fresh, format=kind, dpi=160, metadata=stamp)


def draw(picture: Picture) -> Any:
    """Matplotlib's figure of it.

    Raises:
        MissingExtra: matplotlib is not installed.
    """
    with needed("matplotlib", "plot"):
        import matplotlib
        from matplotlib.figure import Figure
        from matplotlib.text import Text
    with matplotlib.rc_context({**matplotlib.rcParamsDefault, **SETTINGS}):
        figure = Figure(figsize=(picture.width, picture.height), facecolor="white")
        _draw_head(figure, picture)
        for panel in picture.panels:
            _draw_panel(figure, picture, panel)
    for text in figure.findobj(Text):
        text.set_parse_math(False)  # names of joints may contain dollar signs
    return figure


def _draw_head(figure: Any, picture: Picture) -> None:
    """Title, notes and the shared legend."""

    def across(inch: float) -> float:
        """A distance from the left edge, as a share of the width."""
        return inch / picture.width

    def up(inch: float) -> float:
        """A distance from the upper edge, as a height over the lower one, in shares of the height."""
        return 1.0 - inch / picture.height

    left = across(LEFT)
    figure.text(left, up(0.33), picture.headline, fontsize=13, fontweight="bold", color=INK, parse_math=False)
    for line, text in enumerate(picture.lines):
        figure.text(left, up(picture.note_at(line)), text, fontsize=8.5, color=SOFT, parse_math=False)
    for i, key in enumerate(picture.keys):
        row, column = divmod(i, picture.legend_columns)
        place = (across(LEFT + column * picture.key_width), up(picture.legend_at + row * KEY))
        figure.legend(handles=[_handle(key)], loc="upper left", bbox_to_anchor=place, **LEGEND_LOOK)


def _draw_panel(figure: Any, picture: Picture, panel: Panel) -> None:
    """Axes with curves or bars, at their place on the page."""
    box = panel.box
    width, height = picture.width, picture.height
    axes = figure.add_axes((box.left / width, box.bottom / height, box.width / width, box.height / height))
    axes.set_title(panel.title, loc="left", color=panel.colour, fontweight="bold", pad=4.0, parse_math=False)
    if panel.level:
        axes.axhline(0.0, color=SOFT, linewidth=0.7, zorder=1.0)
    for curve in panel.curves:
        _curve(axes, curve)
    if panel.bars:
        _draw_bars(axes, panel)
    else:
        axes.set_ylim(panel.y_range)
        axes.yaxis.set_major_locator(_locator(max(3, min(6, int(box.height / 0.3)))))
        axes.yaxis.set_major_formatter(_formatter())
        axes.set_ylabel(panel.up, color=INK, labelpad=3.0)
    axes.set_xlim(panel.x_range)
    axes.xaxis.set_major_locator(_locator(max(4, int(box.width / 0.6))))
    axes.xaxis.set_major_formatter(_formatter())
    if panel.labelled:
        axes.set_xlabel(panel.across, color=INK, labelpad=2.0)
    axes.tick_params(color=SOFT, labelcolor=INK, length=2.5, labelbottom=panel.labelled)
    axes.grid(color=RULE, linewidth=0.6)
    axes.set_axisbelow(True)
    axes.spines[["top", "right"]].set_visible(False)
    axes.spines[["left", "bottom"]].set_color(SOFT)
    if panel.legend:
        handles = [_handle(key) for key in panel.keys]
        axes.legend(handles=handles, loc="upper left", bbox_to_anchor=(1.01, 1.02), frameon=False, borderaxespad=0.0)


def _curve(axes: Any, curve: Curve) -> None:
    if curve.dots:
        dots = {"linestyle": "none", "marker": "o", "markersize": curve.dot, "markeredgewidth": 0.0}
        axes.plot(curve.x, curve.y, color=curve.colour, gid=curve.name, **dots)
        return
    drawstyle = "steps-post" if curve.held else "default"
    settings = {"linestyle": STYLES[curve.dash], "linewidth": curve.width, "drawstyle": drawstyle}
    axes.plot(curve.x, curve.y, color=curve.colour, gid=curve.name, solid_joinstyle="round", **settings)


def _draw_bars(axes: Any, panel: Panel) -> None:
    places = np.arange(len(panel.bars))[::-1]
    colours = [bar.colour for bar in panel.bars]
    axes.barh(places, [bar.length for bar in panel.bars], height=0.62, color=colours)
    axes.scatter([bar.mark for bar in panel.bars], places, marker="|", s=46, color=colours, linewidths=1.6)
    axes.set_yticks(places, [bar.name for bar in panel.bars])
    axes.set_ylim(panel.y_range)


def _handle(key: Key) -> Any:
    from matplotlib.lines import Line2D

    if key.dots:
        return Line2D([], [], color=key.colour, linestyle="none", marker="o", markersize=3.2, label=key.label)
    return Line2D([], [], color=key.colour, linestyle=STYLES[key.dash], linewidth=key.width, label=key.label)


def _locator(bins: int) -> Any:
    from matplotlib.ticker import MaxNLocator

    return MaxNLocator(nbins=bins, steps=[1, 2, 2.5, 5, 10])


def _formatter() -> Any:
    """Full numbers at every tick, without an offset or power at another place."""
    from matplotlib.ticker import Formatter

    class Plain(Formatter):
        def format_ticks(self, values: Any) -> list[str]:
            """Texts of all ticks of an axis, with as many digits as tell them apart."""
            return tick_texts([float(value) for value in values])

        def __call__(self, value: float, position: int | None = None) -> str:
            return f"{value:.6g}"

    return Plain()


def tick_texts(values: Sequence[float]) -> list[str]:
    """Evenly spaced numbers with just as many digits as are needed to distinguish them."""
    steps = np.diff(values)
    step = float(np.abs(steps).min()) if len(steps) else abs(values[0]) if values else 1.0
    largest = max((abs(value) for value in values), default=0.0)
    # Numbers of a nearly constant signal are written out too: with a power of ten they would need more space.
    if (step >= 1e-4 and largest < 1e6) or (step >= 1e-7 and 0.01 <= largest < 10.0):
        decimals = next((d for d in range(9) if abs(round(step, d) - step) < 1e-3 * step), 9)
        texts = [f"{value:.{decimals}f}" for value in values]
    else:
        digits = 1 + max(0, int(np.ceil(np.log10(largest / step)))) if step > 0 else 6
        mantissas = [f"{value:.{digits}e}".split("e") for value in values]
        texts = [f"{m.rstrip('0').rstrip('.')}e{int(power)}" if float(m) else "0" for m, power in mantissas]
    return [text.replace("-", "\N{MINUS SIGN}") for text in texts]
