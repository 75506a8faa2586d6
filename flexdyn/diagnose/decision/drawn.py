"""Pictures of the residuals before and after the correction, the most informative first."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from flexdyn.arrays import Array
from flexdyn.diagnose.decision.corrected import Corrected
from flexdyn.diagnose.decision.figures import OnData
from flexdyn.diagnose.decision.gaps import Shots
from flexdyn.diagnose.decision.laws_seen import laws_seen
from flexdyn.diagnose.decision.model_rows import ModelRows, summed
from flexdyn.diagnose.decision.naming import Name
from flexdyn.diagnose.equations.localise import traces
from flexdyn.diagnose.report.trace import MeasuredCurve, ResidualTrace, Trajectory
from flexdyn.diagnose.shooting.gap import Shot

HIGHEST_DRAWN_RATE = 200.0
"""Positions are drawn at most so often [Hz]; torques at the rate of the equations' rows."""


def ordered_pictures(rows: ModelRows, found: Corrected, named: Sequence[Name]) -> tuple[ResidualTrace, ...]:
    """Pictures in the order of how much they explain: of the laws found, then two of every equation.

    Args:
        rows: over the data of the fit.
        found: the corrected model.
        named: the names that are reported.
    """
    laws = laws_seen(rows, found, named)
    return (*sorted(laws, key=lambda each: -each.explains), *of_equations(rows, explained=bool(laws)))


def of_equations(rows: ModelRows, *, explained: bool) -> tuple[ResidualTrace, ...]:
    """Two pictures of every equation, those of which the correction takes most first.

    One is over what its residual depends on more, position or velocity, and one over time. Where nothing was found,
    those come first in which most is left: they are what a reader looks for.

    Args:
        rows: by the sensors' noise.
        explained: whether something was found.
    """
    first, last = ((rows.white(at) ** 2).sum(axis=0) for at in (rows.given, rows.after))
    pictures = traces(rows.given, rows.after, rows.whiten.mask)
    shares = (first - last) / max(first.sum(), 1e-300) if explained else last / max(last.sum(), 1e-300)
    equations: list[ResidualTrace] = []
    for k in np.argsort(-shares, kind="stable").tolist():
        over_time, *clouds = pictures[3 * k : 3 * k + 3]
        told = (max(clouds, key=_dependence), over_time)
        equations += [dataclasses.replace(each, explains=float(shares[k])) for each in told]
    return tuple(equations)


def _dependence(cloud: ResidualTrace) -> float:
    """Spread of the averages over neighbours: what the residual changes with."""
    spread = float(np.nanvar(cloud.means[:, 1])) if len(cloud.means) else 0.0
    return spread if np.isfinite(spread) else 0.0


def compared_motions(on: OnData) -> tuple[Trajectory, ...]:
    """Measured and simulated motion of every joint over every span of some data."""
    found = []
    robot = on.rows.given.true.robot
    for j, joint in enumerate(on.rows.given.true.joint_names):
        torques = _torque_curves(on, j, f"torque [{robot.torque_unit(joint)}]")
        for k, part in enumerate(on.parts):
            if len(torques[k].t) < 2:
                continue
            position = None if on.shots is None else _position(on.shots, k, joint, robot.angle_unit(joint))
            found.append(Trajectory(joint, part.recording.name, part.role, position, torques[k]))
    return tuple(found)


def _torque_curves(on: OnData, j: int, label: str) -> list[MeasuredCurve]:
    """Recorded torque of a joint behind the equations' filters, and what each model needs less that (a curve a span).

    The lines are open at masked rows: a joint may rest there, and friction may then have any value.
    """
    left, at = [summed(each, j) for each in on.rows.models], on.rows.after
    clear = on.rows.seen[:, left[0][1]].all(axis=1)
    off = np.where(clear, -np.stack([residual for residual, _ in left]), np.nan)
    curves = []
    parts = zip(on.parts, at.motions, *map(at.by_recording, (at.at_rows("t"), off.T)), strict=True)
    for part, along, t, errors in parts:
        begin = float(part.recording.t[0] - part.data.t[0])
        curves.append(MeasuredCurve(label, begin + t, at.filters.rows(along.tau[:, j]), errors.T))
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
        [_window_errors(shot, which)[:, ::every, column] for shot in (shots.before, shots.calibrated, shots.after)]
    )
    t, measured = (_opened(x[None], x[:, -1:][None])[0] for x in (t, measured))
    return MeasuredCurve(
        f"{own[0].partition('.')[0]} [{unit}]", t, measured, _opened(errors, np.full((3, len(which), 1), np.nan))
    )


def _window_errors(shot: Shot, which: NDArray[np.intp]) -> Array:
    """Simulated less measured (windows, rows, channels); NaN where that was not measured or simulated."""
    there = shot.used[which] & ~shot.failed[which, None, None]
    return np.where(there, shot.residual[which], np.nan)


def _opened(x: Array, end: Array) -> Array:
    """Windows (k, windows, rows) in a row (k, samples), each with one more sample at its end."""
    return np.concatenate([x, end], axis=2).reshape(len(x), -1)
