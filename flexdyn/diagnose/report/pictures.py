"""Pictures that the page's script draws: residuals before and after, and what an experiment would show."""

from __future__ import annotations

from html import escape
from typing import Any

import numpy as np

from flexdyn.arrays import Array
from flexdyn.diagnose.report.suspects import Experiment
from flexdyn.diagnose.report.trace import ForceLoop, ResidualTrace, packed
from flexdyn.plots.palette import INK, RULE

BEFORE, AFTER = "#D9805F", "#1F4E9C"
"""Of what the model left unexplained before and after its correction; page.css has the same."""
FONT = "system-ui, 'Segoe UI', 'Helvetica Neue', Arial, sans-serif"
CONFIG = {
    "displaylogo": False,
    "responsive": True,
    "modeBarButtonsToRemove": ["lasso2d", "select2d"],
    "showSendToCloud": False,
    "showEditInChartStudio": False,
    "plotlyServerURL": "",
}
"""Of every picture; its buttons offer to send data to nobody."""
AXIS = {"gridcolor": RULE, "zeroline": False, "automargin": True, "tickfont": {"size": 11}}
"""Of every axis."""
LEVELS = (10_000, 1500)
"""Between zero and the largest, across and up: many for each dot of a picture that is 500 wide and 200 high."""


def residual_figure(trace: ResidualTrace) -> dict[str, Any]:
    """Data and layout for Plotly in the page: before below, after above it."""
    lines = bool((np.diff(trace.x) > 0.0).all())
    data = [curve(trace.x, trace.before, "before", BEFORE, lines), curve(trace.x, trace.after, "after", AFTER, lines)]
    for column, name, colour in ((1, "before", BEFORE), (2, "after", AFTER)):
        if len(trace.means) and not (len(trace.law) and column == 1):
            data += _stands_out(trace.means[:, 0], trace.means[:, column], f"{name}, averaged", colour)
    if len(trace.law):
        data += _stands_out(trace.law[:, 0], trace.law[:, 1], "the law found", INK)
    layout = page_layout(246, {"l": 58, "r": 10, "t": 10, "b": 44}) | {
        "xaxis": {**AXIS, "title": titled(trace.x_label)},
        "yaxis": {**AXIS, "title": titled(trace.y_label), "zeroline": True, "zerolinecolor": INK, **_frame(trace)},
        "showlegend": False,
    }
    return {**in_columns(data), "layout": layout, "config": CONFIG}


def page_layout(height: int, margin: dict[str, int]) -> dict[str, Any]:
    """What the layouts of all pictures of the page share.

    Args:
        height: of the picture [px].
        margin: around the axes, by side [px].
    """
    font = {"family": FONT, "size": 12, "color": INK}
    white = {"paper_bgcolor": "white", "plot_bgcolor": "white"}
    return {"height": height, "margin": margin, **white, "font": font, "hovermode": "closest"}


def titled(text: str) -> dict[str, Any]:
    """Title of an axis; Plotly takes markup."""
    return {"text": escape(text, quote=False), "standoff": 6}


def _frame(trace: ResidualTrace) -> dict[str, Any]:
    """Limits between which averages can be seen where dots are mostly noise; noise may reach beyond them.

    Where nothing does, a tenth is left free: an axis that Plotly fits to lines lets them run along its frame.
    """
    if not len(trace.means):
        return {}
    most = np.nanmax(np.abs([trace.before, trace.after]), initial=0.0)
    law = float(np.abs(trace.law[:, 1]).max()) if len(trace.law) else 0.0
    size = max(3.0 * float(np.abs(trace.means[:, 1:]).max()), 1.5 * law, float(np.nanstd(trace.after)))
    size = min(size, 1.1 * max(float(most), law))
    return {"range": [-size, size]} if size > 0.0 else {}


def _stands_out(x: Array, y: Array, name: str, colour: str) -> tuple[dict[str, Any], dict[str, Any]]:
    """A line that can be seen among dots of its own colour."""
    line = curve(x, y, name, colour, lines=True)
    return (
        line | {"line": {"color": "white", "width": 5.0}, "hoverinfo": "skip", "hovertemplate": None},
        line | {"line": {"color": colour, "width": 2.4}},
    )


def experiment_figure(plan: Experiment) -> dict[str, Any]:
    """Data and layout for Plotly in the page: the motion above, what the rival would leave of it below, with noise."""
    band = 2.0 * plan.noise
    t, edges = np.concatenate([plan.t, plan.t[::-1]]), np.concatenate([band, -band[::-1]])
    there = np.isfinite(edges)
    noise: dict[str, Any] = {"type": "scatter", "x": t[there], "y": edges[there], "name": "noise", "yaxis": "y2"}
    noise |= {"mode": "lines", "fill": "toself", "fillcolor": f"{BEFORE}55", "line": {"width": 0}, "hoverinfo": "skip"}
    data = [
        curve(plan.t, plan.position, "motion", INK, lines=True),
        noise,
        curve(plan.t, plan.left, "left", AFTER, lines=True) | {"yaxis": "y2"},
    ]
    layout = page_layout(430, {"l": 62, "r": 10, "t": 8, "b": 44}) | {
        "xaxis": {**AXIS, "anchor": "y2", "title": titled("t [s]")},
        "yaxis": {**AXIS, "domain": [0.68, 1.0], "title": titled(plan.labels[0])},
        "yaxis2": {**AXIS, "domain": [0.0, 0.6], "title": titled(plan.labels[1])},
        "showlegend": False,
    }
    return {**in_columns(data), "layout": layout, "config": CONFIG}


def curve(x: Array, y: Array, name: str, colour: str, lines: bool) -> dict[str, Any]:
    """One curve for Plotly, as a line or as dots."""
    trace: dict[str, Any] = {"type": "scatter", "name": name, "x": x, "y": y}
    trace["hovertemplate"] = "%{x:.5g}, %{y:.4g}<extra>" + name + "</extra>"
    if lines:
        return trace | {"mode": "lines", "line": {"color": colour, "width": 1.1}}
    return trace | {"mode": "markers", "marker": {"color": colour, "size": 3.5, "opacity": 0.45}}


def in_columns(data: list[dict[str, Any]]) -> dict[str, Any]:
    """Curves whose columns are written once each, however many curves share them."""
    columns: list[dict[str, Any]] = []
    places: dict[int, int] = {}
    for trace in data:
        for key in ("x", "y"):
            column = trace[key]
            if id(column) not in places:
                places[id(column)] = len(columns)
                columns.append(packed(column, LEVELS[key == "y"]))
            trace[key] = places[id(column)]
    return {"columns": columns, "data": data}


def force_figure(loop: ForceLoop) -> dict[str, Any]:
    """Data and layout for Plotly in the page: force over position to the left, over speed to the right."""
    length, unit = loop.units
    word = "force" if unit == "N" else "torque"
    data = []
    for k, axes in enumerate(({}, {"xaxis": "x2", "yaxis": "y2"})):
        for row, name, colour in ((2, "recorded", INK), (3, "as given", BEFORE), (4, "corrected", AFTER)):
            data.append(curve(loop.columns[k], loop.columns[row], name, colour, lines=True) | axes)
    layout = page_layout(330, {"l": 62, "r": 10, "t": 8, "b": 44}) | {
        "xaxis": {**AXIS, "domain": [0.0, 0.47], "title": titled(f"position [{length}]")},
        "xaxis2": {**AXIS, "domain": [0.53, 1.0], "anchor": "y2", "title": titled(f"speed [{length}/s]")},
        "yaxis": {**AXIS, "title": titled(f"{word} [{unit}]")},
        "yaxis2": {**AXIS, "anchor": "x2", "matches": "y", "showticklabels": False},
        "showlegend": False,
    }
    return {**in_columns(data), "layout": layout, "config": CONFIG}
