"""The picture of measured and simulated motion of every joint, over a window that the reader moves."""

from __future__ import annotations

from typing import Any

from flexdyn.diagnose.report.result import Diagnosis
from flexdyn.diagnose.report.trace import MOST_TRAJECTORY_POINTS, Trajectory, packed

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
    """Position and torque over one time: of each the time, what was measured, and the errors of the models."""
    curves = [each for each in (trajectory.position, trajectory.torque) if each is not None]
    columns = [c for each in curves for c in (packed(each.t, CLOCK), *map(packed, (each.measured, *each.errors)))]
    place = {"joint": trajectory.joint, "span": _span(trajectory), "reach": _reach(trajectory)}
    return {"kind": "motion", **place, "columns": columns, "titles": [each.label for each in curves]}


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
