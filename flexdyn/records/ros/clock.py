"""Convert stamps in whole nanoseconds to times in seconds, and back, exactly."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
import numpy.typing as npt

from flexdyn.arrays import Array

NANO = 10**9
YEAR = 365 * 86400 * NANO
"""Larger stamps are times of day, and are counted from the first one [ns]."""

_EXACT = 2**53
_SAFE = 2**51

Integers = npt.NDArray[np.int64]


def seconds(stamps: Integers, zero: int) -> Array:
    """The doubles nearest to (stamp - zero)/1e9.

    Args:
        stamps: (samples,) [ns].
        zero: the stamp that is time 0 [ns].
    """
    since = stamps - zero
    if len(since) == 0 or max(int(since.max()), -int(since.min())) < _EXACT:
        return np.asarray(since / float(NANO))  # both exact, so the quotient is rounded once
    return np.fromiter((count / NANO for count in since.tolist()), float, len(since))


def nanoseconds(t: Array) -> Integers:
    """The whole nanoseconds nearest to times in seconds."""
    scaled = t * float(NANO)
    if np.abs(scaled).max(initial=0.0) < _SAFE:
        return np.asarray(np.rint(scaled).astype(np.int64))
    return np.array([round(Fraction(time) * NANO) for time in t.tolist()], np.int64)
