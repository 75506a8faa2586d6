"""Two motions at common times: which samples, what is between them, and how far apart they are."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from flexdyn.comparison.motion_sources import HELD, MotionSource
from flexdyn.errors import InputError
from flexdyn.records.signals.gaps import in_gaps
from flexdyn.records.units import split_name

Array = NDArray[np.float64]
LARGEST_COMPARED = 1e290
"""Sums of numbers up to this do not overflow."""
SAME_TIME = 1e-6
"""Times closer than this share of the second's mean sample interval are one: grids of a rate differ by rounding."""


@dataclass(frozen=True, eq=False)
class Difference:
    """One channel of two motions over common times.

    Attributes:
        t: times of the first's samples that the second covers, its gaps left out [s].
        first: samples of the first.
        second: the second at those times.
    """

    t: Array
    first: Array
    second: Array

    @property
    def error(self) -> Array:
        """Second - first."""
        return self.second - self.first

    @property
    def rms(self) -> float:
        """Root of the mean of the squared error."""
        return root_mean_square(self.error)


def common_rows(one: MotionSource, two: MotionSource, start: float | None = None, end: float | None = None) -> slice:
    """Which samples of the first lie in the time that both cover.

    Raises:
        InputError: fewer than two.
    """
    t, other = one.recording.t, two.recording.t
    margin = slack(two)
    low = max(float(other[0]), -math.inf if start is None else start) - margin
    high = min(float(other[-1]), math.inf if end is None else end) + margin
    first, last = int(np.searchsorted(t, low, "left")), int(np.searchsorted(t, high, "right"))
    if last - first < 2:
        problem = f"{one.name} has {max(0, last - first)} samples in the time to be compared"
        spans = f"{one.name} goes from {t[0]:g} to {t[-1]:g} s, {two.name} from {other[0]:g} to {other[-1]:g} s"
        raise InputError(problem, key="t", remedy=f"{spans}: two samples are needed; shift a clock by a map")
    return slice(first, last)


def difference(one: MotionSource, two: MotionSource, channel: str, rows: slice) -> Difference:
    """A channel of two motions at the times of the first's samples.

    Args:
        one: the reference.
        two: taken at the first's times.
        channel: that both have.
        rows: of the first, from `common_rows`.
    """
    t, first = one.recording.t[rows], one.recording[channel][rows]
    if (missed := in_gaps(two.recording.t, t)).any():
        t, first = t[~missed], first[~missed]
        if len(t) < 2:
            remedy = "the recordings have fewer than two samples in common"
            raise InputError(f"{two.name} has a gap there", key=channel, remedy=remedy)
    second = taken_at(two, channel, t)
    for values in (first, second):
        greatest = float(np.abs(values).max())
        if not greatest <= LARGEST_COMPARED:
            remedy = f"the limit is {LARGEST_COMPARED:g}; check the channel's unit"
            raise InputError("the numbers are too great to be compared", key=channel, value=greatest, remedy=remedy)
    return Difference(t, first, second)


def taken_at(source: MotionSource, channel: str, t: Array) -> Array:
    """A channel at other times: held where the signal is, else on the line between two samples.

    Args:
        source: whose channel.
        channel: its name.
        t: within the source's own times [s].
    """
    own, values = source.recording.t, source.recording[channel]
    parts = split_name(channel)
    if parts and parts[0] in HELD:
        rows = np.searchsorted(own, t + slack(source), "right") - 1
        return np.asarray(values[np.clip(rows, 0, None)])
    return np.interp(t, own, values)


def root_mean_square(values: Array) -> float:
    """Root of the mean of the squares, whatever their size."""
    scale = float(np.abs(values).max())  # squares of great numbers would overflow
    return scale * math.sqrt(float(np.mean((values / scale) ** 2))) if scale > 0 else 0.0


def slack(source: MotionSource) -> float:
    """Times of a motion closer than this are one [s]."""
    return SAME_TIME * source.recording.duration / len(source.recording)
