"""A picture drawn by Plotly: a page that works offline and loads nothing."""

from __future__ import annotations

from collections.abc import Mapping
from functools import partial
from html import escape
from pathlib import Path
from typing import Any

import numpy as np

from flexdyn.errors import needed
from flexdyn.io.files import write_text
from flexdyn.io.html import render
from flexdyn.plots.palette import INK, RULE, SOFT
from flexdyn.plots.panel import Curve, Key, Panel
from flexdyn.plots.picture import KEY, LEFT, Picture

DASHES = {"solid": "solid", "dashed": "6px,3px", "dashdot": "7px,2px,2px,2px", "dotted": "2px,2px"}
DOT = 96.0
"""Pixels of the screen in an inch."""
POINT = DOT / 72.0
FONT = "'DejaVu Sans', Verdana, 'Segoe UI', Helvetica, Arial, sans-serif"
TITLE = {"size": 8.5 * POINT, "color": INK}
CONFIG = {
    "displaylogo": False,
    "scrollZoom": True,
    "modeBarButtonsToRemove": ["lasso2d", "select2d"],
    "showSendToCloud": False,
    "plotlyServerURL": "",
}
"""Of every page and notebook; Plotly's own default has a button that uploads the data."""
LEGEND_LAYOUT = {"xanchor": "left", "yanchor": "top", "bgcolor": "rgba(0,0,0,0)", "borderwidth": 0, "tracegroupgap": 0}
_escaped = partial(escape, quote=False)
"""A text as plotly takes it, which knows no &quot;."""


def write_page(picture: Picture, file: Path) -> None:
    """Write the picture as one HTML file that contains plotly.js, completely or not at all.

    Raises:
        InputError: the file cannot be written.
        MissingExtra: plotly is not installed.
    """
    figure = draw(picture)
    import plotly.io

    inner = plotly.io.to_html(figure, config=CONFIG, include_plotlyjs=True, full_html=False, div_id="picture")
    width = int(0.9 * DOT * picture.width)
    write_text(file, render("plots/page.html", title=picture.title, width=width, picture=inner))


def draw(picture: Picture) -> Any:
    """Plotly's figure of it.

    Raises:
        MissingExtra: plotly is not installed.
    """
    with needed("plotly", "plot"):
        import plotly.graph_objects
    data: list[dict[str, Any]] = [_sample(key, _legend_name(i)) for i, key in enumerate(picture.keys)]
    layout: dict[str, Any] = {
        "height": round(DOT * picture.height),
        "margin": dict.fromkeys("lrtb", 0),
        "paper_bgcolor": "white",
        "plot_bgcolor": "white",
        "font": {"family": FONT, "size": 8.5 * POINT, "color": INK},
        "hovermode": "closest",
        "dragmode": "zoom",
        "annotations": _head_layout(picture),
        "shapes": [],
        **_legends(picture),
    }
    legends = {key.label: _legend_name(i) for i, key in enumerate(picture.keys)}
    for number, panel in enumerate(picture.panels, start=1):
        own = _legend_name(len(legends) + number)
        _axes(layout, picture, panel, number)
        if panel.legend:
            layout[own] = _beside(picture, panel)
        data += _content(panel, number, legends, own)
    return plotly.graph_objects.Figure({"data": data, "layout": layout})


def _legends(picture: Picture) -> dict[str, Any]:
    """A separate legend for every line of the shared legend: Plotly would choose other places for them."""
    found = {}
    for i in range(len(picture.keys)):
        row, column = divmod(i, picture.legend_columns)
        left, down = LEFT + column * picture.key_width, picture.legend_at + row * KEY - 0.06
        found[_legend_name(i)] = {"x": left / picture.width, "y": 1.0 - down / picture.height, **LEGEND_LAYOUT}
    return found


def _legend_name(number: int) -> str:
    return "legend" if number == 0 else f"legend{number + 1}"


def _head_layout(picture: Picture) -> list[dict[str, Any]]:
    texts = [_text(picture, LEFT, 0.16, f"<b>{_escaped(picture.headline)}</b>", 13.0 * POINT, INK)]
    for line, note in enumerate(picture.lines):
        texts.append(_text(picture, LEFT, picture.note_at(line) - 0.13, _escaped(note), 8.5 * POINT, SOFT))
    return texts


def _text(picture: Picture, left: float, down: float, text: str, size: float, colour: str) -> dict[str, Any]:
    """A text at a distance from the upper left corner of the page [inch]."""
    place = {"x": left / picture.width, "y": 1.0 - down / picture.height, "xref": "paper", "yref": "paper"}
    anchors = {"xanchor": "left", "yanchor": "top", "showarrow": False, "align": "left"}
    return {**place, **anchors, "text": text, "font": {"size": size, "color": colour}, "borderpad": 0}


def _axes(layout: dict[str, Any], picture: Picture, panel: Panel, number: int) -> None:
    """Axes of a panel, its title, and its legend if it has one."""
    box, width, height = panel.box, picture.width, picture.height
    shared = {"gridcolor": RULE, "linecolor": SOFT, "showline": True, "zeroline": False, "ticks": "outside"}
    shared |= {"tickcolor": SOFT, "ticklen": 3, "automargin": False, "exponentformat": "e"}
    layout[f"xaxis{number}"] = shared | {
        "domain": [box.left / width, (box.left + box.width) / width],
        "anchor": f"y{number}",
        "range": list(panel.x_range),
        "showticklabels": panel.labelled,
        "title": {"text": _escaped(panel.across) if panel.labelled else "", "standoff": 4, "font": TITLE},
        "nticks": max(4, int(box.width / 0.6)),
    }
    first = next((i for i, other in enumerate(picture.panels, start=1) if other.timed), number)
    if panel.timed and number != first:
        layout[f"xaxis{number}"]["matches"] = f"x{first}"
    layout[f"yaxis{number}"] = shared | {
        "domain": [box.bottom / height, (box.bottom + box.height) / height],
        "anchor": f"x{number}",
    }
    if panel.bars:
        names = [_escaped(bar.name) for bar in panel.bars]
        places = list(range(len(names)))[::-1]
        layout[f"yaxis{number}"] |= {"tickvals": places, "ticktext": names, "range": list(panel.y_range)}
    else:
        title = {"text": _escaped(panel.up), "standoff": 6, "font": TITLE}
        ticks = max(4, min(7, int(box.height / 0.3)))
        layout[f"yaxis{number}"] |= {"range": list(panel.y_range), "title": title, "nticks": ticks}
    top = picture.height - box.bottom - box.height
    heading = f"<b>{_escaped(panel.title)}</b>"
    layout["annotations"].append(_text(picture, box.left, top - 0.24, heading, 9.0 * POINT, panel.colour))
    if panel.level:
        line = {"color": SOFT, "width": 1}
        layout["shapes"].append(
            {"type": "line", "xref": f"x{number} domain", "yref": f"y{number}", "x0": 0, "x1": 1, "y0": 0, "y1": 0}
            | {"line": line, "layer": "below"}
        )


def _beside(picture: Picture, panel: Panel) -> dict[str, Any]:
    """The place of a panel's own legend: on its right."""
    box = panel.box
    left, up = box.left + box.width + 0.06, box.bottom + box.height + 0.1
    return {"x": left / picture.width, "y": up / picture.height, **LEGEND_LAYOUT}


def _content(panel: Panel, number: int, legends: Mapping[str, str], own: str) -> list[dict[str, Any]]:
    """Traces of a panel; they belong to its own legend or to lines of the shared one."""
    place = {"xaxis": f"x{number}", "yaxis": f"y{number}"}
    if panel.bars:
        return _bar_traces(panel, place)
    traces = []
    for curve in panel.curves:
        trace = _trace(curve) | place
        if panel.legend:
            trace |= {"name": _escaped(curve.group), "showlegend": True, "legend": own}
        else:
            shared = legends.get(curve.group, "legend")
            trace |= {"legendgroup": _escaped(curve.group), "showlegend": False, "legend": shared}
        traces.append(trace)
    return traces


def _trace(curve: Curve) -> dict[str, Any]:
    trace: dict[str, Any] = {"type": "scatter", "x": curve.x, "y": curve.y, "name": _escaped(curve.name)}
    trace["hovertemplate"] = "%{x:.6g}, %{y:.6g}<extra>%{fullData.name}</extra>"
    if curve.dots:
        return trace | {"mode": "markers", "marker": {"color": curve.colour, "size": curve.dot * POINT}}
    shape = "hv" if curve.held else "linear"
    line = {"color": curve.colour, "width": curve.width * POINT, "dash": DASHES[curve.dash], "shape": shape}
    return trace | {"mode": "lines", "line": line}


def _bar_traces(panel: Panel, place: dict[str, str]) -> list[dict[str, Any]]:
    """Traces of a panel of bars: the bars, and a mark on each for the largest error."""
    up = np.arange(len(panel.bars))[::-1]
    colours = [bar.colour for bar in panel.bars]
    names = [_escaped(bar.name) for bar in panel.bars]
    shared: dict[str, Any] = {"y": up, "text": names, "showlegend": False, **place}
    bars = shared | {"type": "bar", "orientation": "h", "x": [bar.length for bar in panel.bars], "width": 0.62}
    bars |= {"textposition": "none", "hovertemplate": "%{x:.6g}<extra>RMS, %{text}</extra>"}
    bars["marker"] = {"color": colours}
    marks = shared | {"type": "scatter", "mode": "markers", "x": [bar.mark for bar in panel.bars]}
    marks["marker"] = {"symbol": "line-ns", "size": 9, "line": {"color": colours, "width": 2}}
    marks["hovertemplate"] = "%{x:.6g}<extra>largest, %{text}</extra>"
    return [bars, marks]


def _sample(key: Key, legend: str) -> dict[str, Any]:
    """A line of the legend: an empty trace in the same group as the real ones."""
    nowhere = np.array([np.nan])
    empty = Curve(nowhere, nowhere, key.label, key.label, key.colour, key.dash, key.width, key.dots)
    return _trace(empty) | {"legendgroup": _escaped(key.label), "showlegend": True, "legend": legend}
