"""Measured and simulated motion for the report: of the windows, and of the torques that each model needs."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from flexdyn.diagnose.decision.gaps import Shots
from flexdyn.diagnose.decision.held_out import summed
from flexdyn.diagnose.decision.split import DataPart
from flexdyn.diagnose.equations.equations import Equations
from flexdyn.diagnose.report.trajectory import MeasuredCurve, Trajectory
from flexdyn.diagnose.shooting.gap import Shot

Array = NDArray[np.float64]
HIGHEST_DRAWN_RATE = 200.0
"""Positions are drawn at most so often [Hz]; torques at the rate of the equations' rows."""


def trajectories(
    models: Sequence[Equations], seen: NDArray[np.bool_], shots: Shots | None, parts: Sequence[DataPart]
) -> tuple[Trajectory, ...]:
    """Every joint over every span.

    Args:
        models: equations over the spans of the model as given, calibrated and corrected.
        seen: rows that say something (rows of an equation, equations).
        shots: windows in the same spans; None: there are none.
        parts: the spans.
    """
    found = []
    robot = models[0].true.robot
    for j, joint in enumerate(models[0].true.joint_names):
        torques = _torques(models, seen, parts, j, f"torque [{robot.torque_unit(joint)}]")
        for k, part in enumerate(parts):
            if len(torques[k].t) < 2:
                continue
            position = None if shots is None else _position(shots, k, joint, robot.angle_unit(joint))
            found.append(Trajectory(joint, part.recording.name, part.role, position, torques[k]))
    return tuple(found)


def _torques(
    models: Sequence[Equations], seen: NDArray[np.bool_], parts: Sequence[DataPart], j: int, label: str
) -> list[MeasuredCurve]:
    """Recorded torque of a joint behind the equations' filters, and what each model needs less that (a curve a span).

    A row in which an equation says nothing leaves the lines open: there a joint may rest, and friction holds anything.
    """
    left = [summed(at, j) for at in models]
    clear: NDArray[np.bool_] = np.asarray(seen[:, left[0][1]].all(axis=1))
    curves, first = [], 0
    for along, part in zip(models[-1].motions, parts, strict=True):
        filters = models[-1].filters
        rows = slice(first, first + filters.count(len(along.t)))
        first = rows.stop
        begin = float(part.recording.t[0] - part.data.t[0])
        t = begin + along.t[filters.instants(len(along.t))]
        off = np.where(clear[rows], -np.stack([residual[rows] for residual, _ in left]), np.nan)
        curves.append(MeasuredCurve(label, t, filters.rows(along.tau[:, j]), off))
    return curves


def _position(shots: Shots, k: int, joint: str, unit: str) -> MeasuredCurve | None:
    """Measured position over the windows of a span and how far each model is off; lines are open between windows."""
    windows = shots.after.windows
    own = [name for name in (f"q.{joint}", f"theta.{joint}") if name in windows.channels]
    which = np.flatnonzero(windows.places[:, 0] == k)
    if not own or not len(which):
        return None
    column = windows.channels.index(own[0])
    every = max(1, int(1.0 / (HIGHEST_DRAWN_RATE * windows.period)))
    t, measured = windows.t[which, ::every], windows.measured[which, ::every, column]
    errors = np.stack(
        [_error(shot, which)[:, ::every, column] for shot in (shots.before, shots.calibrated, shots.after)]
    )
    t, measured = (_opened(x[None], x[:, -1:][None])[0] for x in (t, measured))
    return MeasuredCurve(
        f"{own[0].partition('.')[0]} [{unit}]", t, measured, _opened(errors, np.full((3, len(which), 1), np.nan))
    )


def _error(shot: Shot, which: NDArray[np.intp]) -> Array:
    """Simulated less measured (windows, rows, channels); NaN where that was not measured or simulated."""
    there = shot.used[which] & ~shot.failed[which, None, None]
    return np.where(there, shot.residual[which], np.nan)


def _opened(x: Array, end: Array) -> Array:
    """Windows (k, windows, rows) in a row (k, samples), each with one more sample at its end."""
    return np.concatenate([x, end], axis=2).reshape(len(x), -1)
