"""Gaps in a recording: times at which nothing was recorded, and across which nothing is made up."""

from __future__ import annotations

import warnings
from collections.abc import Iterable
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from flexdyn.records.notices import RecordingWarning
from flexdyn.records.table import FloatArray

if TYPE_CHECKING:
    from flexdyn.records.recording import Recording

GAP_PERIODS = 10.0
"""Median periods from which the time between two samples is a gap."""
SHORTEST_PIECE = 1.0
"""Pieces between gaps that are shorter tell too little of a motion to be diagnosed [s]."""
GAPS_LISTED = 3


@np.errstate(over="ignore", invalid="ignore")  # times near the greatest double
def gap_limit(t: FloatArray) -> float:
    """Longest time between two samples that is no gap [s]."""
    return GAP_PERIODS * float(np.median(np.diff(t)))


@np.errstate(over="ignore", invalid="ignore")
def gap_rows(t: FloatArray) -> npt.NDArray[np.intp]:
    """Samples after which a gap follows; none where times do not increase."""
    if len(t) < 3 or not np.isfinite(t).all():
        return np.zeros(0, np.intp)
    steps = np.diff(t)
    return np.flatnonzero(steps > gap_limit(t)) if (steps > 0).all() else np.zeros(0, np.intp)


def gaps_of(t: FloatArray) -> tuple[tuple[float, float], ...]:
    """First and last time of every gap [s]: its samples before and after it."""
    return tuple((float(t[row]), float(t[row + 1])) for row in gap_rows(t))


def told(t: FloatArray) -> str:
    """What is said of gaps when a file is read; empty where there are none."""
    found = gaps_of(t)
    if not found:
        return ""
    listed = ", ".join(f"{end - start:.4g} s from t = {start:.6g} s on" for start, end in found[:GAPS_LISTED])
    more = f" and {len(found) - GAPS_LISTED} more" if len(found) > GAPS_LISTED else ""
    count = "a gap" if len(found) == 1 else f"{len(found)} gaps"
    return f"{count} in the data: {listed}{more}; nothing is filled in there"


def in_gaps(t: FloatArray, times: FloatArray) -> npt.NDArray[np.bool_]:
    """Which times lie inside a gap of `t`, its ends not included."""
    rows = gap_rows(t)
    if not len(rows):
        return np.zeros(len(times), bool)
    slack = 1e-6 * gap_limit(t)
    at = np.searchsorted(t[rows], times - slack, "left") - 1
    return np.asarray((at >= 0) & (times < t[rows[np.clip(at, 0, None)] + 1] - slack))


def apart_at_gaps(recordings: Iterable[Recording]) -> tuple[Recording, ...]:
    """The pieces between gaps, as recordings of their own; what has no gap is handed on as it is.

    Warns:
        RecordingWarning: a piece is too short and left out.
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
            problem = (
                f"{len(pieces) - len(kept)} of {len(pieces)} pieces between gaps are shorter than {SHORTEST_PIECE:g} s"
            )
            warnings.warn(f"{rec.name}: {problem} and left out", RecordingWarning, stacklevel=4)
        found += kept or pieces
    return tuple(found)
