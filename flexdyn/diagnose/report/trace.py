"""What is drawn of the residuals of a diagnosis: as many points as the eye needs."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from flexdyn.errors import InputError


@dataclass(frozen=True, eq=False)
class Trace:
    """What the model leaves unexplained, before and after its correction, over what it may depend on.

    Attributes:
        title: joint and side, such as "elbow, motor side".
        x_label: what it is drawn over, with its unit, such as "omega [rad/s]".
        y_label: the residual, with its unit.
        x: over which (points,); where it increases throughout a line is drawn, else dots.
        before: residual of the model as it was given (points,); NaN leaves the line open.
        after: residual of the corrected model (points,).
        means: of dots: x, before and after averaged over neighbours in x (averages, 3); none of a line.
    """

    title: str
    x_label: str
    y_label: str
    x: NDArray[np.float64]
    before: NDArray[np.float64]
    after: NDArray[np.float64]
    means: NDArray[np.float64] = field(default_factory=lambda: np.zeros((0, 3)))

    def __post_init__(self) -> None:
        """Copy and lock.

        Raises:
            InputError: the columns are of different lengths, or x is not finite.
        """
        for name in ("x", "before", "after"):
            column = np.array(getattr(self, name), dtype=float)
            if column.ndim != 1 or len(column) != np.size(self.x):
                raise InputError("columns of one length are needed", key=f"trace.{name}", value=column.shape)
            column.setflags(write=False)
            object.__setattr__(self, name, column)
        means = np.array(self.means, dtype=float)
        means.setflags(write=False)
        object.__setattr__(self, "means", means)
        if not np.isfinite(self.x).all():
            raise InputError("finite numbers are needed", key="trace.x", value=self.title)

    def __reduce__(self) -> tuple[Any, ...]:
        """Unpickle through the constructor, so that arrays are locked again."""
        return (type(self), (self.title, self.x_label, self.y_label, self.x, self.before, self.after, self.means))

    @classmethod
    def thinned(
        cls, title: str, x_label: str, y_label: str, x: ArrayLike, before: ArrayLike, after: ArrayLike
    ) -> Trace:
        """Of long columns only the points that the eye needs.

        Over an x that increases throughout, the outline of both curves is kept; of a cloud, points evenly spread, and
        averages over all of its points.
        """
        from flexdyn.plots.thinning import MOST, SLICES, averages, outline

        columns = [np.asarray(column, dtype=float) for column in (x, before, after)]
        across, *up = columns
        means = np.zeros((0, 3))
        if (np.diff(across) > 0.0).all() and len(across):
            open_ends = np.flatnonzero(np.isnan(up[0]) | np.isnan(up[1]))[:MOST]
            kept = np.union1d(outline(across, *(np.nan_to_num(column) for column in up)), open_ends)
        else:
            kept = np.unique(np.linspace(0, len(across) - 1, min(len(across), SLICES)).round()).astype(np.intp)
            means = averages(np.stack(columns, axis=1))
        across, *up = (column[kept] for column in columns)
        return cls(title, x_label, y_label, across, up[0], up[1], means)
