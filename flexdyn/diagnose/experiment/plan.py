"""A simulated motion as the experiment for the report, with its picture."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from flexdyn.arrays import Array
from flexdyn.diagnose.experiment.rehearsal import Rehearsal
from flexdyn.diagnose.report.suspects import Experiment

PICTURE_POINTS = 240
"""Number of points of a picture; rows between them are averaged."""


def planned(made: Rehearsal, passes: int, names: Sequence[str]) -> Experiment:
    """The experiment with the data of its picture: what the nearest rival leaves where it leaves most.

    Args:
        made: the motion that separates the named hypothesis from its rivals.
        passes: how often it must be repeated.
        names: of the hypotheses.
    """
    near = int(np.argmin(made.sides[0].apart(1)))
    t, left, label = _left(made, near, passes)
    true, j = made.bench.space.equations.true, made.move.joint
    return Experiment(
        motion=made.move.words,
        seconds=passes * made.seconds,
        passes=passes,
        payload=made.move.mass,
        delta_bic=made.apart(passes),
        command=made.bench.command(0, made.move),
        names=(names[0], names[1 + near]),
        t=t,
        position=np.interp(t, made.sides[0].run.t, made.move.path[:, j]),
        left=left,
        labels=(f"{true.joint_names[j]} [{true.robot.angle_unit(j)}]", label),
    )


def _left(made: Rehearsal, near: int, passes: int) -> tuple[Array, Array, str]:
    """Times, what a rival leaves in the equation or channel in which it leaves most, in units of noise, and which."""
    side = made.sides[0]
    if side.by_windows:
        windows, refit = made.bench.windows(side.recording), side.by_windows[near][1]
        t, labels = windows.t[:, :: windows.block].ravel(), [f"error of {name}" for name in windows.channels]
    else:
        equations, refit = side.space.equations, side.by_equations[near][1]
        along, joints = equations.motions[0], equations.true.joint_names
        t = along.t[equations.filters.instants(len(along.t))]
        labels = [f"{kind} equation of {joints[k]}" for k, kind in equations.kinds]
    white = (refit.left(passes)[: refit.rows] / np.sqrt(passes)).reshape(-1, len(labels))
    most = int((white**2).sum(axis=0).argmax())
    size = max(1, len(t) // PICTURE_POINTS)
    blocks = np.arange(0, len(t) - size + 1, size)
    left = np.add.reduceat(white[:, most], blocks)[: len(blocks)] / np.sqrt(size)
    return t[blocks], left, f"{labels[most]}, in units of noise"
