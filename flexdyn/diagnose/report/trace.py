"""What is drawn of the residuals of a diagnosis: as many points as the eye needs."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, fields
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from flexdyn.errors import InputError

NARROW = 500
"""Slices of time whose extremes are drawn: such a picture is half as wide as the page."""


@dataclass(frozen=True, eq=False)
class ResidualTrace:
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
        explains: what goes of the squared residuals of all equations, in units of noise, from before to after, over
            those of the model as given [1]; where nothing was found, the equation's share of what is left.
    """

    title: str
    x_label: str
    y_label: str
    x: NDArray[np.float64]
    before: NDArray[np.float64]
    after: NDArray[np.float64]
    means: NDArray[np.float64] = field(default_factory=lambda: np.zeros((0, 3)))
    law: NDArray[np.float64] = field(default_factory=lambda: np.zeros((0, 2)))
    note: str = ""
    explains: float = math.nan

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
        for name in ("means", "law"):
            table = np.array(getattr(self, name), dtype=float)
            table.setflags(write=False)
            object.__setattr__(self, name, table)
        if not np.isfinite(self.x).all():
            raise InputError("finite numbers are needed", key="trace.x", value=self.title)

    def __reduce__(self) -> tuple[Any, ...]:
        """Unpickle through the constructor, so that arrays are locked again."""
        return (type(self), tuple(getattr(self, entry.name) for entry in fields(self)))

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
            kept = np.unique(np.linspace(0, len(across) - 1, min(len(across), SLICES)).round()).astype(np.intp)
            means = averages(np.stack(columns, axis=1))
        across, *up = (column[kept] for column in columns)
        return cls(title, x_label, y_label, across, up[0], up[1], means)
