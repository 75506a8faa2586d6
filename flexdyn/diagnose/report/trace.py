"""What is drawn of the residuals of a diagnosis: as many points as the eye needs."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from flexdyn.arrays import Array, evenly
from flexdyn.diagnose.report.origin import Role
from flexdyn.io.locked import Locked

NARROW = 500
"""Slices of time whose extremes are drawn: such a picture is half as wide as the page."""
MOST_LOOP_POINTS = 4000
"""Points of a loop of force that are drawn."""
MOST_TRAJECTORY_POINTS = 6000
"""Points of one joint's curves in a whole page, so that six joints over a minute stay below a megabyte."""


@dataclass(frozen=True, eq=False)
class ResidualTrace(Locked):
    """What the model leaves unexplained, before and after its correction, over what it may depend on.

    Attributes:
        title: joint and side, such as "elbow, motor side".
        x_label: what it is drawn over, with its unit, such as "omega [rad/s]".
        y_label: the residual, with its unit.
        x: over which (points,); where it increases throughout a line is drawn, else dots.
        before: residual of the model as it was given (points,); NaN leaves the line open.
        after: residual of the corrected model (points,).
        means: of dots: x, before and after averaged over neighbours in x (averages, 3); none of a line.
        law: of a finding: x and what its law puts into the residual there, in the order of x (points, 2); else none.
        note: what else there is to know of the picture, a sentence or nothing.
        explains: decrease of the squared residuals of all equations, in units of noise, from before to after, over
            those of the model as given [1]; where nothing was found, the equation's share of what is left.
    """

    title: str
    x_label: str
    y_label: str
    x: Array
    before: Array
    after: Array
    means: Array = field(default_factory=lambda: np.zeros((0, 3)))
    law: Array = field(default_factory=lambda: np.zeros((0, 2)))
    note: str = ""
    explains: float = math.nan

    @classmethod
    def thinned(
        cls, title: str, x_label: str, y_label: str, x: ArrayLike, before: ArrayLike, after: ArrayLike
    ) -> ResidualTrace:
        """Of long columns only the points that the eye needs.

        Over an x that increases throughout, the outline of both curves is kept; of a cloud, points evenly spread, and
        averages over all of its points.
        """
        from flexdyn.plots.thinning import SLICES, averages, outline

        columns = [np.asarray(column, dtype=float) for column in (x, before, after)]
        across, *up = columns
        means = np.zeros((0, 3))
        if (np.diff(across) > 0.0).all() and len(across):
            open_ends = np.flatnonzero(np.isnan(up[0]) | np.isnan(up[1]))[:NARROW]
            kept = np.union1d(outline(across, *(np.nan_to_num(column) for column in up), slices=NARROW), open_ends)
        else:
            kept = evenly(len(across), SLICES)
            means = averages(np.stack(columns, axis=1))
        across, *up = (column[kept] for column in columns)
        return cls(title, x_label, y_label, across, up[0], up[1], means)


@dataclass(frozen=True, eq=False)
class MeasuredCurve(Locked):
    """A measured signal and how far each model is off.

    Attributes:
        label: what it is, with its unit, such as "q [rad]".
        t: times within the recording (points,) [s].
        measured: in the label's unit (points,).
        errors: of the model as given, calibrated and corrected (3, points); NaN leaves the line open.
    """

    label: str
    t: Array
    measured: Array
    errors: Array

    def thinned(self, most: int) -> MeasuredCurve:
        """At most so many points, which keep the outline of what is drawn, and those at which a line is open."""
        from flexdyn.plots.thinning import outline

        if len(self.t) <= most:
            return self
        slices, is_open = max(2, most // 9), np.isnan(self.errors).any(axis=0)
        opens = np.flatnonzero(is_open & ~np.roll(is_open, 1))[:slices]
        drawn = np.nan_to_num(np.stack([self.measured, self.errors[0], self.errors[2]]))
        at = np.union1d(outline(self.t, *drawn, slices=slices), opens)
        return MeasuredCurve(self.label, self.t[at], self.measured[at], self.errors[:, at])


@dataclass(frozen=True, eq=False)
class Trajectory:
    """One joint over one span of a recording.

    Attributes:
        joint: its name.
        file: name of the recording.
        role: what the span was used for.
        position: measured, and simulated without feedback over windows of 0.5 s; None: it was not simulated.
        torque: recorded, and needed by each model for the motion that was measured.
    """

    joint: str
    file: str
    role: Role
    position: MeasuredCurve | None
    torque: MeasuredCurve

    def thinned(self, most: int) -> Trajectory:
        """At most so many points of each curve."""
        position = None if self.position is None else self.position.thinned(most)
        return Trajectory(self.joint, self.file, self.role, position, self.torque.thinned(most))


def packed_column(column: ArrayLike, levels: int = 4000) -> dict[str, Any]:
    """A column as whole numbers, each as its step from the one before, which a page holds in little room.

    Args:
        column: numbers; None where it is not finite.
        levels: between zero and the largest of them.
    """
    values = np.asarray(column, dtype=float)
    there = np.isfinite(values)
    unit = float(np.abs(values[there]).max(initial=0.0)) / levels or 1.0
    whole = np.rint(values[there] / unit).astype(np.int64)
    steps: list[int | None] = [None] * len(values)
    for place, step in zip(np.flatnonzero(there).tolist(), np.diff(whole, prepend=0).tolist(), strict=True):
        steps[place] = step
    return {"unit": float(f"{unit:.9g}"), "steps": steps}


@dataclass(frozen=True, eq=False)
class ForceLoop(Locked):
    """Recorded and simulated force of a joint over one span, where a test rig prescribes its motion.

    Attributes:
        joint: its name.
        file: name of the recording.
        role: what the span was used for.
        units: of position and force.
        columns: position, speed, recorded force, that of the model as given, that of the corrected one (5, points).
    """

    joint: str
    file: str
    role: Role
    units: tuple[str, str]
    columns: Array
