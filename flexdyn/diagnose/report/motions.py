"""The picture of measured and simulated motion of every joint, over a window that the reader moves."""

from __future__ import annotations

from typing import Any

from flexdyn.diagnose.report.pictures import AFTER, AXIS, BEFORE, CONFIG, page_layout, titled
from flexdyn.diagnose.report.result import Diagnosis
from flexdyn.diagnose.report.trace import MODELS, MOST_TRAJECTORY_POINTS, MeasuredCurve, Trajectory, packed
from flexdyn.plots.palette import INK

BETWEEN = "#9CA3AF"
"""Of the calibrated model; page.css has the same."""
# Not simplified by Plotly: it would choose points for the whole span, and a window would show straight pieces.
LINES = (
    {"color": BEFORE, "width": 1.6, "simplify": False},
    {"color": BETWEEN, "width": 1.4, "dash": "dot", "simplify": False},
    {"color": AFTER, "width": 1.6, "simplify": False},
)
DRAWN_WINDOW_LENGTHS = (0.5, 1.0, 2.0, 5.0, 10.0, 30.0)
"""Lengths of the drawn window to choose from [s]."""
FIRST_LENGTH = 2.0
"""The length that is drawn at first [s]."""
CLOCK = 1_000_000
"""Levels of a packed time: 60 s are resolved to 0.06 ms."""
ROLES = {"test": "test data", "fit": "data of the fit"}


def controls(diagnosis: Diagnosis) -> dict[str, Any]:
    """What the reader chooses from: values and their texts, and which length is chosen at first."""
    given = diagnosis.trajectories
    longest = max(last - first for first, last in map(_reach, given))
    # The joint whose torque the given model explains worst is shown first.
    shares = {joint: entry.torque.share_before for joint, entry in diagnosis.errors.items()}
    ordered = sorted(given, key=lambda each: -shares.get(each.joint, 0.0))
    return {
        "joints": [(name, name) for name in dict.fromkeys(each.joint for each in ordered)],
        "spans": list({_span(each): _span_text(each) for each in given}.items()),
        "lengths": [(f"{x:g}", f"{x:g} s") for x in DRAWN_WINDOW_LENGTHS if x < longest] + [("all", "all of it")],
        "length": f"{FIRST_LENGTH:g}" if longest > FIRST_LENGTH else "all",
    }


def motion_figures(diagnosis: Diagnosis) -> list[dict[str, Any]]:
    """What the page's script draws, a figure for every joint and span."""
    given = diagnosis.trajectories
    spans = max(1, len({_span(each) for each in given}))
    return [_figure(each.thinned(max(600, MOST_TRAJECTORY_POINTS // spans))) for each in given]


def _figure(trajectory: Trajectory) -> dict[str, Any]:
    """Position, its error, torque and its error, one below the other over one time."""
    curves = [each for each in (trajectory.position, trajectory.torque) if each is not None]
    columns: list[dict[str, Any]] = []
    data: list[dict[str, Any]] = []
    layout = _layout(2 * len(curves))
    for k, curve in enumerate(curves):
        data += _lines(curve, 2 * k, len(columns))
        columns += [packed(curve.t, CLOCK), *map(packed, (curve.measured, *curve.errors))]
        unit = curve.label[curve.label.find("[") :]
        for row, title in ((2 * k, curve.label), (2 * k + 1, f"error {unit}")):
            layout[_axis(row)]["title"] = titled(title)
    return {
        "joint": trajectory.joint,
        "span": _span(trajectory),
        "reach": list(_reach(trajectory)),
        "columns": columns,
        "data": data,
        "layout": layout,
        "config": CONFIG,
    }


def _lines(curve: MeasuredCurve, row: int, first: int) -> list[dict[str, Any]]:
    """What was measured, the models with it, and their errors below; each is in the legend once.

    Args:
        curve: to be drawn.
        row: of its axes.
        first: place of its time among the figure's columns; what was measured and the errors follow.
    """
    line: dict[str, Any] = {"type": "scatter", "mode": "lines", "x": first, "hovertemplate": "%{x:.4f} s, %{y:.5g}"}
    up, below = ({"yaxis": f"y{k + 1}" if k else "y"} for k in (row, row + 1))
    told = {"showlegend": row == 0}
    own: dict[str, Any] = {
        "name": "measured",
        "legendgroup": "measured",
        "line": {"color": INK, "width": 3.4, "simplify": False},
    }
    data = [{**line, **up, **told, **own, "y": first + 1}]
    for k, (name, style) in enumerate(zip(MODELS, LINES, strict=True)):
        own = {"name": name, "legendgroup": name, "line": style, "y": first + 2 + k}
        data += [{**line, **up, **told, **own, "onto": first + 1}, {**line, **below, **own, "showlegend": False}]
    return data


def _layout(rows: int) -> dict[str, Any]:
    """Axes one below the other: of each pair the upper one is the higher one."""
    axis = {**AXIS, "automargin": False}
    heights = [0.28, 0.15] * (rows // 2)
    gap = 0.035
    scale = (1.0 - gap * (rows - 1)) / sum(heights)
    layout = page_layout(170 * rows, {"l": 86, "r": 10, "t": 30, "b": 44}) | {
        "xaxis": {**axis, "anchor": f"y{rows}", "title": titled("t [s]")},
        "legend": {"orientation": "h", "x": 0.0, "y": 1.0, "yanchor": "bottom"},
        "dragmode": "zoom",
    }
    top = 1.0
    for row, height in enumerate(heights):
        bottom = top - height * scale
        layout[_axis(row)] = {**axis, "domain": [max(bottom, 0.0), top], "zeroline": row % 2 == 1, "zerolinecolor": INK}
        top = bottom - gap
    return layout


def _axis(row: int) -> str:
    return f"yaxis{row + 1}" if row else "yaxis"


def _span(each: Trajectory) -> str:
    return f"{each.role} {each.file} {each.torque.t[0]:.6g}"


def _span_text(each: Trajectory) -> str:
    """The span that the slider reaches over."""
    first, last = _reach(each)
    return f"{ROLES[each.role]}: {each.file} {first:.4g} to {last:.4g} s"


def _reach(each: Trajectory) -> tuple[float, float]:
    """First and last time of its curves [s]."""
    ends = [float(curve.t[k]) for curve in (each.position, each.torque) if curve is not None for k in (0, -1)]
    return min(ends), max(ends)
