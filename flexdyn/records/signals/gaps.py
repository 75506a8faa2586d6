"""Gaps in a recording: times without samples, across which nothing is interpolated."""

from __future__ import annotations

import warnings
from collections.abc import Iterable
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from flexdyn.arrays import Array, Flags, Indices
from flexdyn.records.notices import RecordingWarning

if TYPE_CHECKING:
    from flexdyn.records.recording import Recording

GAP_PERIODS = 10.0
"""The time between two samples is a gap if it is longer than so many median periods [1]."""
SHORTEST_PIECE = 1.0
"""Shortest piece between gaps that is used in a diagnosis [s]."""
GAPS_LISTED = 3
_SAME = 1e-3


@np.errstate(over="ignore", invalid="ignore")  # times near the largest double
def gap_limit(t: Array) -> float:
    """Longest time between two samples that is no gap [s]."""
    return GAP_PERIODS * float(np.median(np.diff(t)))


@np.errstate(over="ignore", invalid="ignore")
def gap_rows(t: Array) -> Indices:
    """Indices of samples that are followed by a gap; none if times do not increase."""
    if len(t) < 3 or not np.isfinite(t).all():
        return np.zeros(0, np.intp)
    steps = np.diff(t)
    return np.flatnonzero(steps > gap_limit(t)) if (steps > 0).all() else np.zeros(0, np.intp)


def gaps_of(t: Array) -> tuple[tuple[float, float], ...]:
    """First and last time of every gap [s]: its samples before and after it."""
    return tuple((float(t[row]), float(t[row + 1])) for row in gap_rows(t))


def gaps_text(t: Array) -> str:
    """The text about gaps when a file is read; empty if there are none."""
    found = gaps_of(t)
    if not found:
        return ""
    listed = ", ".join(f"{end - start:.4g} s from t = {start:.6g} s on" for start, end in found[:GAPS_LISTED])
    more = f" and {len(found) - GAPS_LISTED} more" if len(found) > GAPS_LISTED else ""
    count = "a gap" if len(found) == 1 else f"{len(found)} gaps"
    return f"{count} in the data: {listed}{more}; nothing is filled in there"


def in_gaps(t: Array, times: Array) -> Flags:
    """Whether each time is inside a gap of `t`, without its ends."""
    rows = gap_rows(t)
    if not len(rows):
        return np.zeros(len(times), bool)
    slack = 1e-6 * gap_limit(t)
    at = np.searchsorted(t[rows], times - slack, "left") - 1
    return np.asarray((at >= 0) & (times < t[rows[np.clip(at, 0, None)] + 1] - slack))


def to_nearest(t: npt.NDArray[Any], times: npt.NDArray[Any]) -> npt.NDArray[Any]:
    """The distance of each time to the nearest of `t`."""
    right = np.clip(np.searchsorted(t, times), 1, len(t) - 1)
    return np.asarray(np.minimum(np.abs(times - t[right - 1]), np.abs(times - t[right])))


def rows_held(t: Array, times: Array) -> Indices:
    """The last row of `t` at or before each time; stamps are rounded, so up to a thousandth of a period after it."""
    slack = _SAME * float(np.median(np.diff(t)))
    return np.asarray(np.clip(np.searchsorted(t, times + slack, "right") - 1, 0, None))


def apart_at_gaps(recordings: Iterable[Recording]) -> tuple[Recording, ...]:
    """The pieces between gaps as separate recordings; a recording without gaps is returned as it is.

    Warns:
        RecordingWarning: a piece is too short and is left out.
    """
    found: list[Recording] = []
    for rec in recordings:
        rows = gap_rows(rec.t)
        if not len(rows):
            found.append(rec)
            continue
        pieces = rec.split(gaps=gap_limit(rec.t))
        kept = [piece for piece in pieces if piece.duration >= SHORTEST_PIECE]
        if len(kept) < len(pieces) and kept:
            count = f"{len(pieces) - len(kept)} of {len(pieces)} pieces between gaps"
            text = f"{rec.name}: {count} are shorter than {SHORTEST_PIECE:g} s and left out"
            warnings.warn(text, RecordingWarning, stacklevel=4)
        found += kept or pieces
    return tuple(found)
