"""Clocks of a channel map: the common times, and channels with delayed stamps."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np
import numpy.typing as npt

from flexdyn.checks import Array
from flexdyn.errors import InputError
from flexdyn.records.channelmap.description import TIME, TimeSource, column_name
from flexdyn.records.channelmap.known_units import UNITS, plain_unit
from flexdyn.records.table import Table, as_floats, check_finite, check_time
from flexdyn.records.units import UNITLESS

_EXACT = 2**53
_SLACK = 1e-6
"""Share of a sample step by which a sample may be beyond the end of a delayed channel, because of rounding [1]."""


def with_times(time: TimeSource, raw: npt.NDArray[Any], stated: Mapping[str, str | None]) -> Array:
    """A raw column of time in seconds; nanoseconds since 1970 are exact if the first one is subtracted.

    Raises:
        InputError: contradictory units, units that are no times, or integers that doubles cannot represent.
    """
    name = column_name(time.source)
    unit = UNITS[_unit(time, stated.get(name, ""))]
    if raw.dtype.kind in "iu" and raw.ndim == 1 and len(raw) and int(abs(raw.astype(np.float64)).max()) > _EXACT:
        if time.start != "zero":
            remedy = "give start: zero"
            raise InputError("integers beyond 2^53 are no exact doubles", key="time.start", value=name, remedy=remedy)
        raw = raw - raw[0] if raw.dtype.kind == "i" else raw.astype(np.int64) - np.int64(raw[0])
    return as_floats(raw, name, copy=False) * unit.numerator / unit.denominator


def undelayed(table: Table, delays: Mapping[str, float]) -> Table:
    """The table with delayed channels moved back to the common times.

    A sample with stamp t of a channel with delay d was taken at t - d. Therefore the value at the common time t is the
    one with the stamp t + d, interpolated linearly between the two samples around it. Rows without samples on both
    sides are left out: the last d seconds, or the first if d is negative.

    Raises:
        InputError: times that do not increase, gaps in such a channel, or a delay as long as the recording.
    """
    if not delays:
        return table
    t = table.columns[TIME]
    check_time(t, table.rows)
    for name in delays:
        check_finite(table.columns[name], name, table.rows)
    slack = _SLACK * (t[-1] - t[0]) / (len(t) - 1)
    first, last = t[0] - min(0.0, *delays.values()) - slack, t[-1] - max(0.0, *delays.values()) + slack
    inside = np.flatnonzero((t >= first) & (t <= last))
    if len(inside) < 2:
        name = max(delays, key=lambda channel: abs(delays[channel]))
        problem = f"the delay leaves {len(inside)} samples of {t[-1] - t[0]:.6g} s"
        raise InputError(problem, key=f"channels.{name}.delay", value=delays[name], remedy="give it in s")
    columns = {name: values[inside] for name, values in table.columns.items()}
    for name, delay in delays.items():
        columns[name] = np.interp(t[inside] + delay, t, table.columns[name])
    return replace(table, columns=columns, rows=table.rows.taken(inside))


def clocked(time: TimeSource, t: Array) -> Array:
    """The times from the requested start, shifted."""
    if time.start == "zero" and len(t):
        t = t - t[0]
    return t + time.shift if time.shift else t


def _unit(time: TimeSource, stated: str | None) -> str:
    """The valid unit: the map's, else the file's, else s."""
    given = None if time.unit is None else plain_unit(time.unit)
    found = "" if stated is None or stated.strip() in UNITLESS else plain_unit(stated)
    if given is None and (stated is None or (found and UNITS.get(found, UNITS["m"]).quantity != "time")):
        problem = "the file states a unit of time that is not known"
        raise InputError(problem, key="time.unit", value=stated, remedy="give s, ms, us, ns, min or h")
    if given and found and given != found:
        remedy = f"the file says {stated!r}: give that, or leave unit out"
        raise InputError("not the unit that the file states", key="time.unit", value=time.unit, remedy=remedy)
    return given or found or "s"
