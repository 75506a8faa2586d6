"""Two motions at common times: the samples, the interpolation, and the differences."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from flexdyn.arrays import Array
from flexdyn.comparison.motion_sources import MotionSource
from flexdyn.errors import InputError
from flexdyn.records.signals.gaps import in_gaps
from flexdyn.records.units import is_held

LARGEST_COMPARED = 1e290
"""Largest number that is compared: sums of such numbers do not overflow."""
SAME_TIME = 1e-6
"""Times that differ by less than this share of the mean sample interval are equal: grids differ by rounding [1]."""


@dataclass(frozen=True, eq=False)
class Difference:
    """One channel of two motions over common times.

    Attributes:
        t: times of the first's samples that the second covers, its gaps left out [s].
        first: values of the first.
        second: values of the second at those times.
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
    """Rows of the first motion's samples within the common time.

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
        two: the other motion, evaluated at the times of the first.
        channel: a common channel.
        rows: of the first, from `common_rows`.

    Raises:
        InputError: all of these times are in gaps of the other, or the numbers are too great.
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
    """A channel at other times: held if the signal is held, else interpolated linearly.

    Args:
        source: the motion.
        channel: name of its channel.
        t: within the source's own times [s].
    """
    own, values = source.recording.t, source.recording[channel]
    if is_held(channel):
        rows = np.searchsorted(own, t + slack(source), "right") - 1
        return np.asarray(values[np.clip(rows, 0, None)])
    return np.interp(t, own, values)


def root_mean_square(values: Array) -> float:
    """Root mean square, without overflow."""
    scale = float(np.abs(values).max())  # squares of large numbers would overflow
    return scale * math.sqrt(float(np.mean((values / scale) ** 2))) if scale > 0 else 0.0


def slack(source: MotionSource) -> float:
    """Times of a motion that differ by less are taken as equal [s]."""
    return SAME_TIME * source.recording.duration / len(source.recording)
