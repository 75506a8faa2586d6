"""Measured and simulated motion of a joint, as the report draws it: as many points as the eye needs."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from flexdyn.diagnose.report.measures import Role

Array = NDArray[np.float64]
MODELS = ("as given", "calibrated", "corrected")
"""Models whose errors a curve holds."""
MOST_TRAJECTORY_POINTS = 6000
"""Points of one joint's curves in a whole page, so that six joints over a minute stay below a megabyte."""


@dataclass(frozen=True, eq=False)
class MeasuredCurve:
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

    def __post_init__(self) -> None:
        """Copy and lock."""
        for name in ("t", "measured", "errors"):
            column = np.array(getattr(self, name), dtype=float)
            column.setflags(write=False)
            object.__setattr__(self, name, column)

    def __reduce__(self) -> tuple[Any, ...]:
        """Unpickle through the constructor, so that arrays are locked again."""
        return (type(self), (self.label, self.t, self.measured, self.errors))

    def thinned(self, most: int) -> MeasuredCurve:
        """At most so many points: of every slice of time the first one, and the extremes of what is drawn.

        Points at which a line is open are kept besides.
        """
        count = len(self.t)
        if count <= most:
            return self
        drawn = np.stack([self.measured, self.errors[0], self.errors[2]])
        open_ends = np.isnan(self.errors).any(axis=0)
        edges = np.linspace(0, count, max(2, most // 9) + 1).astype(np.intp)[:-1]
        pieces = [np.split(row, edges[1:]) for row in np.nan_to_num(drawn)]
        kept: list[Any] = [
            edges,
            edges - 1,
            np.flatnonzero(open_ends & ~np.roll(open_ends, 1))[: most // 9],
            [count - 1],
        ]
        for row in pieces:
            kept.append(edges + [int(piece.argmin()) for piece in row])
            kept.append(edges + [int(piece.argmax()) for piece in row])
        at = np.unique(np.clip(np.concatenate(kept), 0, count - 1)).astype(np.intp)
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


def packed(column: ArrayLike, levels: int = 4000) -> dict[str, Any]:
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
