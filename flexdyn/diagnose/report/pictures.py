"""Pictures that the page's script draws: motions, residuals before and after, forces, what an experiment would show.

What is drawn stands here; `looks.js` says how it looks.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from flexdyn.arrays import Array
from flexdyn.diagnose.report.result import Diagnosis
from flexdyn.diagnose.report.suspects import Experiment
from flexdyn.diagnose.report.trace import MOST_TRAJECTORY_POINTS, ForceLoop, ResidualTrace, Trajectory, packed_column

LEVELS = {"x": 10_000, "y": 1500}
"""Between zero and the largest, across and up: many for each dot of a picture that is 500 wide and 200 high."""
BELOW = ("x", "y2")
"""Axes of a second room below the first one."""
PICTURES = 6
"""Number of pictures of residuals that are shown at once; the others open on a click."""
OPEN_PICTURE_SHARE = 0.01
"""Smallest share of the squared residuals that a picture explains to be shown at once [1]."""
DRAWN_WINDOW_LENGTHS = (0.5, 1.0, 2.0, 5.0, 10.0, 30.0)
"""Lengths of the drawn window to choose from [s]."""
FIRST_LENGTH = 2.0
"""The length that is drawn at first [s]."""
CLOCK = 1_000_000
"""Levels of a packed time: 60 s are resolved to 0.06 ms."""
ROLES = {"test": "test data", "fit": "data of the fit"}


def shown_at_once(diagnosis: Diagnosis) -> int:
    """Number of pictures that are shown at once: those that explain something, two to six."""
    telling = [k for k, each in enumerate(diagnosis.residuals) if not each.explains < OPEN_PICTURE_SHARE]
    return min(PICTURES, max(2, telling[-1] + 1 if telling else 0), len(diagnosis.residuals))


def residual_figure(trace: ResidualTrace) -> dict[str, Any]:
    """Before below, after above it; over dots their averages and the law that was found."""
    look = "line" if (np.diff(trace.x) > 0.0).all() else "dots"
    curves = [curve_entry(trace.x, getattr(trace, name), name, name, look) for name in ("before", "after")]
    for column, name in ((1, "before"), (2, "after")):
        if len(trace.means) and not (len(trace.law) and column == 1):
            curves.append(curve_entry(trace.means[:, 0], trace.means[:, column], f"{name}, averaged", name, "bold"))
    if len(trace.law):
        curves.append(curve_entry(trace.law[:, 0], trace.law[:, 1], "the law found", "ink", "bold"))
    return {**figure_entry("residual", curves, trace.x_label, trace.y_label), "limit": _limit(trace)}


def _limit(trace: ResidualTrace) -> float | None:
    """Limit within which averages can be seen where dots are mostly noise; noise may reach beyond it. None: all.

    Where nothing does, a tenth is left free: an axis that Plotly fits to lines lets them run along its frame.
    """
    if not len(trace.means):
        return None
    most = np.nanmax(np.abs([trace.before, trace.after]), initial=0.0)
    law = float(np.abs(trace.law[:, 1]).max()) if len(trace.law) else 0.0
    size = max(3.0 * float(np.abs(trace.means[:, 1:]).max()), 1.5 * law, float(np.nanstd(trace.after)))
    return min(size, 1.1 * max(float(most), law)) or None


def experiment_figure(plan: Experiment) -> dict[str, Any]:
    """The motion above, what the rival would leave of it below, with two standard deviations of noise."""
    t, edges = plan.t[[0, -1, -1, 0]], np.array([2.0, 2.0, -2.0, -2.0])
    curves = [
        curve_entry(plan.t, plan.position, "motion", "ink"),
        curve_entry(t, edges, "noise", "between", "band", BELOW),
        curve_entry(plan.t, plan.left, "left", "after", below=BELOW),
    ]
    return figure_entry("plan", curves, "t [s]", *plan.labels)


def force_figure(loop: ForceLoop) -> dict[str, Any]:
    """Force over position to the left, over speed to the right."""
    length, unit = loop.units
    curves = [
        curve_entry(loop.columns[k], loop.columns[row], name, tone, below=axes)
        for k, axes in enumerate((None, ("x2", "y2")))
        for row, name, tone in ((2, "recorded", "ink"), (3, "as given", "before"), (4, "corrected", "after"))
    ]
    force = f"{'force' if unit == 'N' else 'torque'} [{unit}]"
    return figure_entry("force", curves, f"position [{length}]", f"speed [{length}/s]", force)


def curve_entry(
    x: Array, y: Array, name: str, tone: str, look: str = "line", below: tuple[str, str] | None = None
) -> dict[str, Any]:
    """One curve: a colour of page.css, a look of looks.js, and its axes; None: the first ones."""
    return {"x": x, "y": y, "name": name, "colour": tone, "look": look, "below": below}


def figure_entry(kind: str, curves: list[dict[str, Any]], *titles: str) -> dict[str, Any]:
    """Curves whose columns are written once each, however many curves share them, and the titles of their axes."""
    columns: list[dict[str, Any]] = []
    places: dict[int, int] = {}
    for each in curves:
        for key, levels in LEVELS.items():
            column = each[key]
            if id(column) not in places:
                places[id(column)] = len(columns)
                columns.append(packed_column(column, levels))
            each[key] = places[id(column)]
    return {"kind": kind, "columns": columns, "curves": curves, "titles": titles}


def controls(diagnosis: Diagnosis) -> dict[str, Any]:
    """What the reader chooses from: values and their texts, and which length is chosen at first."""
    given = diagnosis.trajectories
    longest = max(last - first for first, last in map(_reach, given))
    # The joint whose torque the given model explains worst is shown first.
    shares = {joint: entry.torque.share_before for joint, entry in diagnosis.errors.items()}
    ordered = sorted(given, key=lambda each: -shares.get(each.joint, 0.0))
    return {
        "joints": [(name, name) for name in dict.fromkeys(each.joint for each in ordered)],
        "spans": list({_span_key(each): _span_text(each) for each in given}.items()),
        "lengths": [(f"{x:g}", f"{x:g} s") for x in DRAWN_WINDOW_LENGTHS if x < longest] + [("all", "all of it")],
        "length": f"{FIRST_LENGTH:g}" if longest > FIRST_LENGTH else "all",
    }


def motion_figures(diagnosis: Diagnosis) -> list[dict[str, Any]]:
    """What the page's script draws, a figure for every joint and span."""
    given = diagnosis.trajectories
    spans = max(1, len({_span_key(each) for each in given}))
    return [_figure(each.thinned(max(600, MOST_TRAJECTORY_POINTS // spans))) for each in given]


def _figure(trajectory: Trajectory) -> dict[str, Any]:
    """Position and torque over one time: of each the time, what was measured, and the errors of the models."""
    curves = [each for each in (trajectory.position, trajectory.torque) if each is not None]
    columns = [
        c for each in curves for c in (packed_column(each.t, CLOCK), *map(packed_column, (each.measured, *each.errors)))
    ]
    place = {"joint": trajectory.joint, "span": _span_key(trajectory), "reach": _reach(trajectory)}
    return {"kind": "motion", **place, "columns": columns, "titles": [each.label for each in curves]}


def _span_key(each: Trajectory) -> str:
    return f"{each.role} {each.file} {each.torque.t[0]:.6g}"


def _span_text(each: Trajectory) -> str:
    """The span that the slider reaches over."""
    first, last = _reach(each)
    return f"{ROLES[each.role]}: {each.file} {first:.4g} to {last:.4g} s"


def _reach(each: Trajectory) -> tuple[float, float]:
    """First and last time of its curves [s]."""
    ends = [float(curve.t[k]) for curve in (each.position, each.torque) if curve is not None for k in (0, -1)]
    return min(ends), max(ends)
