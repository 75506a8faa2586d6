"""Trimming, splitting and shifting recordings; no sample is changed."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np

from flexdyn.checks import Array, check_known, number
from flexdyn.errors import InputError
from flexdyn.records.meta import as_plain
from flexdyn.records.table import Table

if TYPE_CHECKING:
    from flexdyn.records.recording import Recording


def trimmed(rec: Recording, start: float | None = None, end: float | None = None) -> Recording:
    """The samples from `start` to `end`, both included.

    Args:
        rec: the recording.
        start: first time kept [s], on the recording's own clock; None keeps the beginning.
        end: last time kept [s]; None keeps the end.

    Raises:
        InputError: fewer than two samples lie between.
    """
    first = -math.inf if start is None else _time("start", start)
    last = math.inf if end is None else _time("end", end)
    low, high = np.searchsorted(rec.t, first, "left"), np.searchsorted(rec.t, last, "right")
    if high - low < 2:
        problem = f"{max(0, int(high - low))} samples lie from {first:g} to {last:g} s"
        remedy = f"the recording runs from {float(rec.t[0]):g} to {float(rec.t[-1]):g} s"
        raise InputError(problem, key="end" if start is None else "start", remedy=remedy)
    return samples_between(rec, int(low), int(high))


def split(rec: Recording, *, at: Sequence[float] | None = None, gaps: float | None = None) -> tuple[Recording, ...]:
    """Split a recording at given times, or wherever samples are missing.

    Args:
        rec: the recording.
        at: times [s]; a sample at one of them begins the next piece.
        gaps: split between samples with a longer distance than this [s].

    Returns:
        Pieces in order. With `gaps`, single samples between two gaps are left out.

    Raises:
        InputError: neither or both of `at` and `gaps`, a piece shorter than two samples, or nothing left.
    """
    if (at is None) == (gaps is None):
        raise InputError("one way to split is needed", key="at", remedy="give either at=[times] or gaps=seconds")
    if at is not None:
        times = sorted(_time("at", time) for time in at)
        rows = [0, *(int(row) for row in np.searchsorted(rec.t, times, "left")), len(rec)]
        for i in range(len(rows) - 1):
            if rows[i + 1] - rows[i] < 2:
                value, remedy = times[min(i, len(times) - 1)], "every piece needs two samples or more"
                raise InputError("the split leaves a piece too short", key="at", value=value, remedy=remedy)
        return tuple(samples_between(rec, low, high) for low, high in pairwise(rows))
    remedy = "give seconds greater than 0"
    longest = number("gaps", gaps, "not a length of time", above=0.0, infinite=True, remedy=remedy)
    ends = np.flatnonzero(np.diff(rec.t) > longest) + 1
    rows = [0, *(int(end) for end in ends), len(rec)]
    pieces = tuple(samples_between(rec, low, high) for low, high in pairwise(rows) if high - low >= 2)
    if not pieces:
        raise InputError("every piece would have one sample", key="gaps", value=gaps, remedy="give a longer gap")
    return pieces


def shifted(rec: Recording, seconds: float | Mapping[str, float]) -> Recording:
    """Shift the times of a recording, or of some of its channels against the others.

    Args:
        rec: the recording.
        seconds: offset of every time [s]; or a mapping from channels to their offsets. Then the channel is
            interpolated (a commanded torque is held) at the times that all channels still cover.

    Raises:
        InputError: not finite, an unknown channel, or nothing left in common.
    """
    if not isinstance(seconds, Mapping):
        by = _time("seconds", seconds)
        return made(rec, {"t": rec.t + by, **rec.channels})
    for channel in seconds:
        check_known(channel, rec.channels, "no such channel", key=f"seconds.{channel}", channel=channel)
    shifts = {channel: _time(f"seconds.{channel}", value) for channel, value in seconds.items()}
    first = float(rec.t[0]) + max([0.0, *shifts.values()])
    last = float(rec.t[-1]) + min([0.0, *shifts.values()])
    kept = trimmed(rec, first, last)
    columns: dict[str, Array] = {"t": kept.t, **kept.channels}
    for channel, by in shifts.items():
        if by:
            alone = made(rec, {"t": rec.t, channel: rec[channel]}, meta=False)
            columns[channel] = alone.resample(times=np.clip(kept.t - by, rec.t[0], rec.t[-1]))[channel]
    return made(rec, columns)


def samples_between(rec: Recording, low: int, high: int) -> Recording:
    """The samples from one row to before another.

    Args:
        rec: the recording.
        low: first row.
        high: row behind the last one.
    """
    return made(rec, {"t": rec.t[low:high], **{name: values[low:high] for name, values in rec.channels.items()}})


def with_channels(rec: Recording, channels: Mapping[str, Array]) -> Recording:
    """The recording with these channels, in place of its own of the same names."""
    return made(rec, {"t": rec.t, **rec.channels, **channels})


def made(rec: Recording, columns: Mapping[str, Array], *, meta: bool = True) -> Recording:
    """A recording of the same kind with other samples.

    Args:
        rec: that gives kind, name and meta data.
        columns: ``t`` and the channels.
        meta: whether the meta data stay.
    """
    copies = {name: np.array(values, float) for name, values in columns.items()}
    return type(rec).from_table(Table(copies, as_plain(rec.meta) if meta else {}), rec.name)


def _time(key: str, value: object) -> float:
    return number(key, value, "not a time", remedy="give seconds")
