"""Pictures that the page's script draws: residuals before and after, and what an experiment would show."""

from __future__ import annotations

import math
from html import escape
from typing import Any

import numpy as np
from numpy.typing import NDArray

from flexdyn.diagnose.report.experiment import Experiment
from flexdyn.diagnose.report.trace import Trace
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
DIGITS = 6
"""Of the numbers in a residual picture."""


def residual_figure(trace: Trace) -> dict[str, Any]:
    """Data and layout for Plotly in the page: before below, after above it."""
    lines = bool((np.diff(trace.x) > 0.0).all())
    data = [
        _points(trace.x, trace.before, "before", BEFORE, lines),
        _points(trace.x, trace.after, "after", AFTER, lines),
    ]
    for column, name, colour in ((1, "before", BEFORE), (2, "after", AFTER)):
        if len(trace.means):
            data += _average(trace.means[:, 0], trace.means[:, column], name, colour)
    axis = {"gridcolor": RULE, "zeroline": False, "automargin": True, "tickfont": {"size": 11}}
    layout = {
        "height": 270,
        "margin": {"l": 58, "r": 10, "t": 34, "b": 44},
        "paper_bgcolor": "white",
        "plot_bgcolor": "white",
        "font": {"family": FONT, "size": 12, "color": INK},
        "title": {
            "text": f"<b>{escape(trace.title, quote=False)}</b>",
            "x": 0.0,
            "xanchor": "left",
            "font": {"size": 13},
        },
        "xaxis": {**axis, "title": {"text": escape(trace.x_label, quote=False), "standoff": 6}},
        "yaxis": {
            **axis,
            "title": {"text": escape(trace.y_label, quote=False), "standoff": 6},
            "zeroline": True,
            "zerolinecolor": INK,
            **_frame(trace),
        },
        "showlegend": False,
        "hovermode": "closest",
    }
    return {"data": data, "layout": layout, "config": CONFIG}


def _frame(trace: Trace) -> dict[str, Any]:
    """Limits between which averages can be seen where dots are mostly noise; noise may reach beyond them."""
    if not len(trace.means):
        return {}
    most = np.nanmax(np.abs([trace.before, trace.after]), initial=0.0)
    size = max(3.0 * float(np.abs(trace.means[:, 1:]).max()), float(np.nanstd(trace.after)))
    return {"range": [-size, size]} if 0.0 < size < most else {}


def _average(
    x: NDArray[np.float64], y: NDArray[np.float64], name: str, colour: str
) -> tuple[dict[str, Any], dict[str, Any]]:
    """A line that stands out from dots of its own colour."""
    line = _points(x, y, f"{name}, averaged", colour, lines=True)
    return (
        line | {"line": {"color": "white", "width": 5.0}, "hoverinfo": "skip"},
        line | {"line": {"color": colour, "width": 2.4}},
    )


def experiment_figure(plan: Experiment) -> dict[str, Any]:
    """Data and layout for Plotly in the page: the motion above, what the rival would leave of it below, with noise."""
    band = 2.0 * plan.noise
    t, edges = np.concatenate([plan.t, plan.t[::-1]]), np.concatenate([band, -band[::-1]])
    there = np.isfinite(edges)
    noise: dict[str, Any] = {
        "type": "scatter",
        "x": _plain(t[there]),
        "y": _plain(edges[there]),
        "name": "noise",
        "yaxis": "y2",
    }
    noise |= {"mode": "lines", "fill": "toself", "fillcolor": f"{BEFORE}55", "line": {"width": 0}, "hoverinfo": "skip"}
    data = [
        _points(plan.t, plan.position, "motion", INK, lines=True),
        noise,
        _points(plan.t, plan.left, "left", AFTER, lines=True) | {"yaxis": "y2"},
    ]
    axis = {"gridcolor": RULE, "zeroline": False, "automargin": True, "tickfont": {"size": 11}}
    layout = {
        "height": 430,
        "margin": {"l": 62, "r": 10, "t": 8, "b": 44},
        "paper_bgcolor": "white",
        "plot_bgcolor": "white",
        "font": {"family": FONT, "size": 12, "color": INK},
        "xaxis": {**axis, "anchor": "y2", "title": {"text": "t [s]", "standoff": 6}},
        "yaxis": {**axis, "domain": [0.68, 1.0], "title": {"text": escape(plan.labels[0], quote=False)}},
        "yaxis2": {**axis, "domain": [0.0, 0.6], "title": {"text": escape(plan.labels[1], quote=False)}},
        "showlegend": False,
        "hovermode": "closest",
    }
    return {"data": data, "layout": layout, "config": CONFIG}


def _points(x: NDArray[np.float64], y: NDArray[np.float64], name: str, colour: str, lines: bool) -> dict[str, Any]:
    trace: dict[str, Any] = {"type": "scatter", "name": name, "x": _plain(x), "y": _plain(y)}
    trace["hovertemplate"] = "%{x:.5g}, %{y:.4g}<extra>" + name + "</extra>"
    if lines:
        return trace | {"mode": "lines", "line": {"color": colour, "width": 1.1}}
    return trace | {"mode": "markers", "marker": {"color": colour, "size": 3.5, "opacity": 0.45}}


def _plain(column: NDArray[np.float64]) -> list[float | None]:
    """Numbers of few digits; null, which leaves a gap, where there is none."""
    return [float(f"{value:.{DIGITS}g}") if math.isfinite(value) else None for value in column.tolist()]
