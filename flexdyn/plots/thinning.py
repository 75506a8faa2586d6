"""Fewer points for drawing: of a long recording only those that the outline of its curve needs."""

from __future__ import annotations

from typing import Any

import numpy as np

from flexdyn.arrays import Array, Indices
from flexdyn.plots.panel import Curve, short
from flexdyn.records.signals.gaps import gap_rows

MOST_CURVE_POINTS = 6000
"""Curves of up to this many samples are drawn as they are."""
SLICES = 1500
"""Number of slices of time for longer curves, each narrower than a dot of the picture; their extremes are kept."""
FINE, COARSE = 800, 240
"""Cells in each direction of a plane in which a curve is drawn: for a line, and for dots."""
MOST_AVERAGES, DOTS_IN_AN_AVERAGE = 80, 20
"""Largest number of averages through a cloud of dots, and smallest number of dots in each."""
MOST_PLANE_POINTS = 24000
"""Largest number of points of a line in a plane; a curve that needs more is drawn as dots."""


def outline(t: Array, *signals: Array, slices: int = SLICES) -> Indices:
    """Samples to draw so that the curve looks as if all of them were drawn.

    Of every slice of time the first, last, smallest and largest sample of each signal are kept: no peak is lost, and no
    line goes where the curve never was. A curve with up to four samples in a slice keeps all.

    Args:
        t: times, increasing (samples,).
        signals: drawn over time (samples,).
        slices: of time, each narrower than a dot of the picture.

    Returns:
        Indices, increasing.
    """
    if len(t) <= 4 * slices:
        return np.arange(len(t))
    edges = np.searchsorted(t, np.linspace(t[0], t[-1], slices + 1)[1:-1])
    bounds = np.unique(np.concatenate([[0], edges, [len(t)]]))
    kept = [bounds[:-1], bounds[1:] - 1]
    for signal in signals:
        pieces = np.split(signal, bounds[1:-1])
        kept.append(bounds[:-1] + [int(piece.argmin()) for piece in pieces])
        kept.append(bounds[:-1] + [int(piece.argmax()) for piece in pieces])
    return np.unique(np.concatenate(kept)).astype(np.intp)


def broken(t: Array, values: Array, kept: Indices) -> tuple[Array, Array]:
    """The kept samples of a curve over time, with a NaN in each gap, where the curve is interrupted.

    Args:
        t: times of all samples.
        values: of all samples.
        kept: indices of the samples that are drawn, increasing.
    """
    rows = gap_rows(t)
    if not len(rows):
        return t[kept], values[kept]
    kept = np.unique(np.concatenate([kept, rows, rows + 1]))
    at = np.searchsorted(kept, rows, "right")
    middle = 0.5 * (t[rows] + t[rows + 1])
    return np.insert(t[kept], at, middle), np.insert(values[kept], at, np.nan)


def curve_over_time(t: Array, values: Array, name: str, group: str, colour: str, **look: Any) -> Curve:
    """A curve over time with as many points as its outline needs, interrupted in gaps.

    Args:
        t: times of all samples.
        values: of all samples.
        name: of the signal.
        group: of the line in the legend, which is shortened.
        colour: of the line.
        look: further attributes of the curve.
    """
    return Curve(*broken(t, values, outline(t, values)), name, short(group), colour, **look)


def outline_in_plane(x: Array, y: Array) -> tuple[Indices, bool]:
    """Samples to draw of a long curve in a plane, such as position and velocity.

    Of consecutive samples in the same one of 800 by 800 cells, the first is kept. If more than `MOST_PLANE_POINTS`
    remain, one sample of every cell of a coarser grid is drawn as a dot: the plane is almost full there.

    Args:
        x: horizontal values (samples,).
        y: vertical values (samples,).

    Returns:
        Indices, increasing; whether they are dots rather than a line.
    """
    if len(x) <= MOST_CURVE_POINTS:
        return np.arange(len(x)), False
    ends = [int(extreme) for signal in (x, y) for extreme in (signal.argmin(), signal.argmax())] + [len(x) - 1]
    cells = _cells(x, FINE) * (FINE + 1) + _cells(y, FINE)
    moved = np.flatnonzero(np.diff(cells, prepend=-1))
    if len(moved) <= MOST_PLANE_POINTS:
        return np.unique(np.concatenate([moved, ends])), False
    cells = _cells(x, COARSE) * (COARSE + 1) + _cells(y, COARSE)
    _, first = np.unique(cells, return_index=True)
    return np.unique(np.concatenate([first, ends])), True


def _cells(values: Array, count: int) -> Indices:
    unit = values / (float(np.abs(values).max()) or 1.0)  # neither overflows nor vanishes
    low, high = float(unit.min()), float(unit.max())
    return np.floor((unit - low) / (high - low or 1.0) * count).astype(np.intp)


def averages(columns: Array) -> Array:
    """Averages of equal numbers of neighbours in the first column; rows that are not finite are left out.

    Args:
        columns: the horizontal and the vertical values (points, columns).

    Returns:
        Averages in the order of the first column (averages, columns); empty if there are too few points.
    """
    finite = columns[np.isfinite(columns).all(axis=1)]
    count = min(MOST_AVERAGES, len(finite) // DOTS_IN_AN_AVERAGE)
    if count < 2:
        return np.zeros((0, columns.shape[1]))
    ordered = finite[np.argsort(finite[:, 0], kind="stable")]
    return np.array([part.mean(axis=0) for part in np.array_split(ordered, count)])
