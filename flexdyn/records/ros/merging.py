"""Convert topics with different times to the times of one of them, with a sentence that says how."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from flexdyn.arrays import Array
from flexdyn.errors import InputError
from flexdyn.records.request import Request
from flexdyn.records.ros.clock import Integers, seconds
from flexdyn.records.ros.columns import CONVENTIONAL
from flexdyn.records.ros.series import Series
from flexdyn.records.signals.gaps import in_gaps, to_nearest


@dataclass(frozen=True)
class Merged:
    """Columns of several topics at common times.

    Attributes:
        stamps: of the samples (samples,) [ns].
        columns: by name.
        said: how topics were aligned, one sentence for each; empty if their times are the same.
    """

    stamps: Integers
    columns: Mapping[str, Array]
    said: tuple[str, ...] = ()


def merged(every: Sequence[Series], request: Request) -> Merged:
    """The columns of all topics at the times of one.

    That topic is ``source.topic``, else the only topic of joint states, else the one with the most messages. Samples at
    which another topic has no data (before its first message, after its last one, or in a gap) are left out.

    Args:
        every: columns of each topic with its stamps.
        request: what is wanted, and how the file is laid out.

    Raises:
        InputError: topics without common times, or stamps of a topic that do not increase.
    """
    if all(np.array_equal(every[0].stamps, other.stamps) for other in every[1:]):
        columns = {name: values for series in every for name, values in series.columns.items()}
        return Merged(every[0].stamps, columns)
    for series in every:
        _check_increasing(series)
    base = _base(every, request)
    zero = int(base.stamps[0])
    kept = np.ones(len(base.stamps), bool)
    for other in every:
        kept &= (base.stamps >= other.stamps[0]) & (base.stamps <= other.stamps[-1])
        kept &= ~in_gaps(seconds(other.stamps, zero), seconds(base.stamps, zero))
    if kept.sum() < 2:
        names = " and ".join(series.topic for series in every)
        remedy = "read one topic at a time, or take the time of recording: source: {clock: bag}"
        raise InputError(f"{names} have no time in common", remedy=remedy, channel="t")
    stamps = base.stamps[kept]
    columns, said = {}, []
    for series in every:
        same = series is base
        rows = kept if same else slice(None)
        for name, values in series.columns.items():
            columns[name] = values[rows] if same else _put(series, values, stamps, zero, request.layout.merge)
        if not same:
            said.append(_sentence(series, base, stamps, request.layout.merge))
    return Merged(stamps, columns, tuple(said))


def _base(every: Sequence[Series], request: Request) -> Series:
    named = [series for series in every if series.topic == request.layout.topic]
    states = [series for series in every if series.msgtype in CONVENTIONAL]
    alone = named or (states if len(states) == 1 else [])
    return alone[0] if alone else max(every, key=lambda series: len(series.stamps))


def _put(series: Series, values: Array, stamps: Integers, zero: int, merge: str) -> Array:
    """A column at other stamps, which are within the range of its own."""
    if merge == "hold":
        return np.asarray(values[np.searchsorted(series.stamps, stamps, "right") - 1])
    return np.interp(seconds(stamps, zero), seconds(series.stamps, zero), values)


def _sentence(series: Series, base: Series, stamps: Integers, merge: str) -> str:
    """What was done to the times of a topic, for the user."""
    how = "as its last message said" if merge == "hold" else "on straight lines between its messages"
    apart = 1e3 * seconds(to_nearest(series.stamps, stamps), 0)
    return (
        f"{series.topic} ({_rate(series):.4g} Hz) was put on the times of {base.topic} ({_rate(base):.4g} Hz), {how}; "
        f"its messages are {np.median(apart):.3g} ms from these times in the median, at most {apart.max():.3g} ms; "
        f"{len(stamps)} of {len(base.stamps)} samples are common. Other times: source: {{topic: ..., merge: ...}}; "
        "a constant lag: delay of the channel"
    )


def _rate(series: Series) -> float:
    return 1e9 / float(np.median(np.diff(series.stamps)))


def _check_increasing(series: Series) -> None:
    steps: npt.NDArray[np.int64] = np.diff(series.stamps)
    if len(series.stamps) < 2 or not (steps > 0).all():
        row = int(np.argmin(steps > 0)) + 1 if len(steps) else 0
        problem = f"message {row} of {series.topic}: stamps do not increase"
        remedy = "read this topic alone with a repair, or take the time of recording: source: {clock: bag}"
        raise InputError(problem, remedy=remedy, row=row, channel="t")
