"""Recordings side by side: positions in one file, currents in another, at one file's times."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from flexdyn.checks import Array, check_known
from flexdyn.errors import InputError
from flexdyn.records.meta import as_plain
from flexdyn.records.signals.gaps import in_gaps, rows_held, to_nearest
from flexdyn.records.table import Table

if TYPE_CHECKING:
    from flexdyn.records.recording import Recording

BESIDE_METHODS = ("linear", "hold")
"""``linear``: interpolation between two samples; ``hold``: the value of the last sample."""
START = "start_ns"
"""Key of a recording's meta: the time of day of its zero [ns]."""


def beside(first: Recording, others: Sequence[Recording], method: str = "linear") -> Recording:
    """Combine the channels of several recordings at the times of the first.

    If two files give the time of day of their start, it aligns them; otherwise they are taken to use the same clock,
    which can be corrected before with ``rec.shifted``. Times at which another recording has a gap, or no samples on
    both sides, are left out. ``meta["notes"]`` says how each recording was aligned.

    Args:
        first: the recording whose times are used.
        others: with other channels.
        method: interpolation of the others: ``linear`` or ``hold``.

    Raises:
        InputError: no such method, a channel that two of them have, or no two times in common.
    """
    remedy = f"known: {', '.join(BESIDE_METHODS)}"
    check_known(method, BESIDE_METHODS, "no such method", key="method", value=method, remedy=remedy)
    columns: dict[str, Array] = {"t": first.t, **first.channels}
    meta = as_plain(first.meta)
    units, notes = dict(meta.get("units", {})), list(meta.get("notes", ()))
    kept = np.ones(len(first), bool)
    taken = np.interp if method == "linear" else _held
    for other in others:
        for name in other.channels:
            if name in columns:
                problem, remedy = f"{_label(first)} and {_label(other)} both have it", "leave it out of one of them"
                raise InputError(problem, key=name, remedy=f"{remedy}, by a channel map", channel=name)
        t, clock = _on_the_clock_of(first, other)
        kept &= (first.t >= t[0]) & (first.t <= t[-1]) & ~in_gaps(t, first.t)
        columns |= {name: taken(first.t, t, values) for name, values in other.channels.items()}
        units |= as_plain(other.meta).get("units", {})
        notes += [*as_plain(other.meta).get("notes", ()), _said(first, other, t, method, clock)]
    if kept.sum() < 2:
        spans = "; ".join(f"{_label(each)} {each.t[0]:.6g} to {each.t[-1]:.6g} s" for each in (first, *others))
        remedy = "shift one of them: time: {shift: SECONDS} in its channel map"
        raise InputError("the recordings have no two times in common", key="t", value=spans, remedy=remedy)
    notes.append(f"{int(kept.sum())} of {len(first)} samples of {_label(first)} are common")
    chosen = {name: np.array(values[kept]) for name, values in columns.items()}
    known = meta | {"notes": notes} | ({"units": units} if units else {})
    if forced := tuple(dict.fromkeys(joint for each in (first, *others) for joint in each.prescribed)):
        known["prescribed"] = list(forced)
    return type(first).from_table(Table(chosen, known), "+".join(each.name for each in (first, *others) if each.name))


def _on_the_clock_of(first: Recording, other: Recording) -> tuple[Array, str]:
    """Times of a recording on the clock of another, and the reason in words."""
    began, later = (each.meta.get(START) for each in (first, other))
    if isinstance(began, int) and isinstance(later, int):
        late = (later - began) / 1e9
        return np.asarray(other.t + late), f"by the time of day: it started {late:.6g} s later"
    return other.t, "both clocks are assumed to agree"


def _held(times: Array, t: Array, values: Array) -> Array:
    return np.asarray(values[rows_held(t, times)])


def _said(first: Recording, other: Recording, t: Array, method: str, clock: str) -> str:
    """A sentence that says how a recording was aligned."""
    off = float(np.median(to_nearest(t, first.t)))
    how = "on straight lines between its samples" if method == "linear" else "each sample held to the next"
    return (
        f"{_label(other)} ({other.rate:.4g} Hz) was put on the times of {_label(first)} ({first.rate:.4g} Hz), {how};"
        f" {clock}; its samples are {1e3 * off:.3g} ms from these times in the median"
    )


def _label(rec: Recording) -> str:
    return rec.name or "a recording"
