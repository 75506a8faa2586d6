"""Repairs of faults in a log: each is made only on request and reports how many rows it changed."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from flexdyn.arrays import Array, Flags, Indices
from flexdyn.checks import check_known, number
from flexdyn.errors import InputError
from flexdyn.records.table import Rows, Table, as_floats, check_lengths, check_time_named

LONGEST_FILLED_GAP = 0.1
"""Longest gap that is filled by default [s]."""

_Columns = dict[str, Array]


@dataclass(frozen=True)
class Repair:
    """A requested repair.

    Attributes:
        name: ``sort_time``, ``drop_duplicate_times``, ``drop_backwards``, ``drop_nan`` or ``fill_nan``.
        longest: longest gap that ``fill_nan`` fills, from the sample before it to the one after it [s].
    """

    name: str
    longest: float = LONGEST_FILLED_GAP

    def to_plain(self) -> str | dict[str, Any]:
        """In the form of a map file."""
        return self.name if self.longest == LONGEST_FILLED_GAP else {self.name: {"longest": self.longest}}


def repairs_of(entries: Any) -> tuple[Repair, ...]:
    """The repairs that a list of names asks for; ``{fill_nan: {longest: 0.5}}`` is a name with its number.

    Raises:
        InputError: no such repair, or a number that does not fit.
    """
    if isinstance(entries, str | Mapping):
        entries = [entries]
    if not isinstance(entries, Iterable):
        remedy = f"known: {', '.join(KNOWN)}"
        raise InputError("a list of repairs is needed", key="repair", value=entries, remedy=remedy)
    return tuple(_repair(entry) for entry in entries)


def repaired(table: Table, repairs: Iterable[Repair]) -> Table:
    """The table after the repairs, in their order; ``meta["repairs"]`` gives the number of rows that each changed.

    * ``sort_time`` sorts the rows by time; rows at one time keep their order.
    * ``drop_duplicate_times`` keeps the first of the rows at one time.
    * ``drop_backwards`` drops rows whose time lies before that of an earlier row.
    * ``drop_nan`` drops rows in which some column is no finite number.
    * ``fill_nan`` interpolates linearly where a channel is no finite number.

    Args:
        table: with ``t``; its arrays are used without copying.
        repairs: in order.

    Returns:
        A table whose rows keep their numbers in the file for messages.

    Raises:
        InputError: a gap that is too long to be filled, or no column that could be repaired.
    """
    repairs = tuple(repairs)
    if not repairs:
        return table
    check_time_named(table.columns)
    columns = {name: as_floats(values, name, copy=False) for name, values in table.columns.items()}
    check_lengths(columns, table.rows)
    rows, done = table.rows, []
    for repair in repairs:
        if repair.name == "fill_nan":
            columns, touched = _filled(columns, rows, repair.longest)
        else:
            order = _ORDERS[repair.name](columns)
            moved = order != np.arange(len(order))
            touched = int(moved.sum()) if len(order) == len(columns["t"]) else len(columns["t"]) - len(order)
            if touched:
                columns = {name: values[order] for name, values in columns.items()}
                rows = rows.taken(order)
        done.append({"repair": repair.name, "rows": touched})
    for values in columns.values():
        values.setflags(write=False)
    meta = {**table.meta, "repairs": [*table.meta.get("repairs", ()), *done]}
    return replace(table, columns=dict(columns), meta=meta, rows=rows)


def _repair(entry: Any) -> Repair:
    """A repair by its name, or by its name and numbers."""
    name, numbers = entry, None
    if isinstance(entry, Repair):
        return entry
    if isinstance(entry, Mapping) and len(entry) == 1:
        name, numbers = next(iter(entry.items()))
    check_known(name, KNOWN, "no such repair", key="repair", value=name)
    if numbers is None:
        return Repair(name)
    if name != "fill_nan" or not isinstance(numbers, Mapping) or set(numbers) != {"longest"}:
        remedy = "write its name, or {fill_nan: {longest: 0.5}} to fill longer gaps"
        raise InputError("the repair takes no such number", key=f"repair.{name}", value=numbers, remedy=remedy)
    key = f"repair.{name}.longest"
    return Repair(name, number(key, numbers["longest"], "a time above zero is needed, in s", above=0.0))


_ORDERS: Mapping[str, Callable[[_Columns], Indices]] = {
    "sort_time": lambda columns: np.argsort(columns["t"], kind="stable"),
    "drop_duplicate_times": lambda columns: np.sort(np.unique(columns["t"], return_index=True, equal_nan=False)[1]),
    # A time that is no number is before no other time.
    "drop_backwards": lambda columns: np.flatnonzero(~(columns["t"] < np.fmax.accumulate(columns["t"]))),
    "drop_nan": lambda columns: np.flatnonzero(np.logical_and.reduce([np.isfinite(x) for x in columns.values()])),
}
"""The rows that a repair keeps, in their new order."""
KNOWN = (*_ORDERS, "fill_nan")
"""Names of the repairs."""


def _filled(columns: _Columns, rows: Rows, longest: float) -> tuple[_Columns, int]:
    """The columns without gaps, and in how many rows something was filled in."""
    t = columns["t"]
    broken = ~np.isfinite(t)
    if broken.any():
        raise rows.error("the time itself is missing", index=int(np.argmax(broken)), channel="t", remedy="drop_nan")
    touched = np.zeros(len(t), bool)
    whole = {}
    for name, values in columns.items():
        good = np.isfinite(values)
        if good.all():
            whole[name] = values
            continue
        _check_fillable(t, good, name, rows, longest)
        whole[name] = np.where(good, values, np.interp(t, t[good], values[good]))
        touched |= ~good
    return whole, int(touched.sum())


def _check_fillable(t: Array, good: Flags, name: str, rows: Rows, longest: float) -> None:
    """Refuse a gap that is too long to be filled, or open at an end."""
    known = np.flatnonzero(good)
    if not len(known) or not good[0] or not good[-1]:
        at = 0 if not good[0] else int(known[-1]) + 1
        raise rows.error("the gap has no sample on one side", index=at, channel=name, remedy="drop_nan drops such rows")
    gaps = np.diff(t[known])
    long = (np.diff(known) > 1) & ~(gaps <= longest) | (gaps <= 0)
    if long.any():
        at = int(np.argmax(long))
        if gaps[at] <= 0:
            remedy = "repair the times first: sort_time, drop_duplicate_times"
            raise rows.error("times do not increase", index=int(known[at + 1]), channel="t", remedy=remedy)
        remedy = f"allow it with {{fill_nan: {{longest: {math.ceil(gaps[at] * 100) / 100:g}}}}}, or drop_nan"
        problem = f"a gap of {gaps[at]:.6g} s, longer than {longest:g} s"
        raise rows.error(problem, index=int(known[at]) + 1, channel=name, remedy=remedy)
