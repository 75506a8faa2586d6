"""A simulated motion as the experiment for the report, with its picture."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from flexdyn.arrays import Array
from flexdyn.diagnose.experiment.rehearsal import Rehearsal
from flexdyn.diagnose.report.suspects import Experiment

PICTURE_POINTS = 1500
"""Number of points of a picture."""


def planned(made: Rehearsal, passes: int, names: Sequence[str]) -> Experiment:
    """The experiment with the data of its picture: what the nearest rival leaves where it leaves most.

    Args:
        made: the motion that separates the named hypothesis from its rivals.
        passes: how often it must be repeated.
        names: of the hypotheses.
    """
    near = int(np.argmin(made.sides[0].apart(1)))
    true, run, j = made.bench.space.equations.true, made.sides[0].run, made.move.joint
    t = np.linspace(run.t[0], run.t[-1], PICTURE_POINTS)
    left, label = _left_most(made, near, passes, t)
    return Experiment(
        motion=made.move.words,
        seconds=passes * made.seconds,
        passes=passes,
        payload=made.move.mass,
        delta_bic=made.apart(passes),
        command=made.bench.command(0, made.move),
        names=(names[0], names[1 + near]),
        t=t,
        position=np.interp(t, run.t, made.move.path[:, j]),
        left=left,
        labels=(f"{true.joint_names[j]} [{true.robot.angle_unit(j)}]", f"{label} [noise]"),
    )


def _left_most(made: Rehearsal, near: int, passes: int, t: Array) -> tuple[Array, str]:
    """What a rival leaves in the equation or channel in which it leaves most, in units of noise, and which that is.

    It is NaN between simulated windows.
    """
    side = made.sides[0]
    if side.by_windows:
        windows, refit = made.bench.windows(side.recording), side.by_windows[near][1]
        times, labels = windows.t[:, :: windows.block].ravel(), list(windows.channels)
    else:
        equations, refit = side.space.equations, side.by_equations[near][1]
        times, joints = equations.at_rows("t"), equations.true.joint_names
        labels = [f"{joints[k]}, {kind}" for k, kind in equations.kinds]
    white = (refit.left(passes)[: refit.rows] / np.sqrt(passes)).reshape(-1, len(labels))
    most = int((white**2).sum(axis=0).argmax())
    at = np.maximum(np.searchsorted(times, t, side="right") - 1, 0)
    there = np.abs(t - times[at]) < 2.0 * np.median(np.diff(times))
    return np.where(there, white[at, most], np.nan), labels[most]
