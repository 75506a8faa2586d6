"""Pictures of a report: laws with their fitted numbers, and residuals before and after."""

from __future__ import annotations

import base64
import dataclasses
import io
import math
from html import escape
from typing import Any

import numpy as np
from numpy.typing import NDArray

from flexdyn.diagnose.result import Suspect, Trace
from flexdyn.effects import Effect, catalogue
from flexdyn.errors import InputError
from flexdyn.model import FlexibleJointModel
from flexdyn.plots.laws import law_figure
from flexdyn.plots.palette import INK, RULE

BEFORE, AFTER = "#D9805F", "#1F4E9C"
"""Of what the model left unexplained before and after its correction; page.css has the same."""
FONT = "system-ui, 'Segoe UI', 'Helvetica Neue', Arial, sans-serif"
CONFIG = {"displaylogo": False, "responsive": True, "modeBarButtonsToRemove": ["lasso2d", "select2d"]}
DIGITS = 6
"""Of the numbers in a residual picture."""
SIZE = (5.0, 3.6)
"""Of a law's picture [inch]: the letters are as large as those beside it."""


def effect_of(suspect: Suspect) -> Effect | None:
    """The effect with its estimated numbers; None where some were not estimated, or make no sense."""
    kind = catalogue().get(suspect.effect)
    if kind is None:
        return None
    given: dict[str, Any] = {"joint": suspect.joint, "side": suspect.side, **suspect.place}
    given |= {name: number.value for name, number in suspect.parameters.items()}
    known = {field.name for field in dataclasses.fields(kind)}  # type: ignore[arg-type]
    try:
        effect = kind.from_dict({key: value for key, value in given.items() if key in known and value is not None})
    except InputError:
        return None
    return None if effect.is_neutral else effect


def law_picture(suspect: Suspect, model: FlexibleJointModel) -> str | None:
    """The law with its fitted numbers, as the address of an SVG picture that stands in the page itself.

    None where the effect has no law to draw.

    Raises:
        MissingExtra: matplotlib is not installed.
    """
    effect = effect_of(suspect)
    joint = suspect.joint
    slides = joint in model.joint_names and model.robot.angle_unit(str(joint)) == "m"
    try:
        figure = None if effect is None else law_figure(effect, prismatic=slides)
    except InputError:
        return None
    if figure is None:
        return None
    import matplotlib

    figure.set_size_inches(SIZE)
    stream = io.BytesIO()
    with matplotlib.rc_context({"svg.hashsalt": "flexdyn"}):
        figure.savefig(stream, format="svg", metadata={"Date": None}, bbox_inches="tight", pad_inches=0.05)
    return f"data:image/svg+xml;base64,{base64.b64encode(stream.getvalue()).decode('ascii')}"


def residual_figure(trace: Trace) -> dict[str, Any]:
    """Data and layout for Plotly in the page: before below, after above it."""
    lines = bool((np.diff(trace.x) > 0.0).all())
    data = [
        _points(trace.x, trace.before, "before", BEFORE, lines),
        _points(trace.x, trace.after, "after", AFTER, lines),
    ]
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
        },
        "showlegend": False,
        "hovermode": "closest",
    }
    return {"data": data, "layout": layout, "config": CONFIG}


def _points(x: NDArray[np.float64], y: NDArray[np.float64], name: str, colour: str, lines: bool) -> dict[str, Any]:
    trace: dict[str, Any] = {"type": "scatter", "name": name, "x": _plain(x), "y": _plain(y)}
    trace["hovertemplate"] = "%{x:.5g}, %{y:.4g}<extra>" + name + "</extra>"
    if lines:
        return trace | {"mode": "lines", "line": {"color": colour, "width": 1.1}}
    return trace | {"mode": "markers", "marker": {"color": colour, "size": 3.5, "opacity": 0.6}}


def _plain(column: NDArray[np.float64]) -> list[float | None]:
    """Numbers of few digits; null, which leaves a gap, where there is none."""
    return [float(f"{value:.{DIGITS}g}") if math.isfinite(value) else None for value in column.tolist()]
