"""Apply a channel map: a file's raw columns become SI channels at common times."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import numpy.typing as npt

from flexdyn.checks import Array, check_known
from flexdyn.errors import InputError
from flexdyn.records.channelmap.convert import conversions_of, stated_units, undetermined_units, valid_unit
from flexdyn.records.channelmap.couplings import couple
from flexdyn.records.channelmap.description import TIME, ChannelMap, TimeSource, column_name
from flexdyn.records.channelmap.expression import check_names
from flexdyn.records.channelmap.known_units import UNITS
from flexdyn.records.repairs import Repair, repaired
from flexdyn.records.table import Table, as_floats, check_finite, check_lengths, check_time

_EXACT = 2**53
_SLACK = 1e-6
"""Share of a sample step by which a sample may be beyond the end of a delayed channel, because of rounding [1]."""


@np.errstate(over="ignore", invalid="ignore", divide="ignore")  # an overflow gives no finite number, which is refused
def apply_map(table: Table, channel_map: ChannelMap, repairs: Sequence[Repair] = ()) -> Table:
    """Convert a file's table by a channel map.

    The order is: units and gears, repairs, delays, couplings, channels computed from others, and the clock's start.

    Args:
        table: raw columns by name, numbered ones as ``column n``; it is emptied.
        channel_map: the meaning of the columns.
        repairs: requested in addition to the map's own.

    Returns:
        ``t`` and channels in SI; ``meta["map"]`` is the map, ``meta["units"]`` has the units that names do not
        determine.

    Raises:
        InputError: an unknown column, units that do not fit, or a repair that is not possible.
    """
    stated = stated_units(table)
    conversions = conversions_of(channel_map, stated)
    units = undetermined_units(channel_map, conversions)
    raw = _Raw(table, channel_map)
    columns: dict[str, Any] = {}
    if channel_map.time.rate is None:
        columns[TIME] = with_times(channel_map.time, raw.take(channel_map.time.source, "time.from"), stated)
    for channel, convert in zip(channel_map.channels, conversions, strict=True):
        values = raw.take(channel.source, f"channels.{channel.name}.from")
        columns[channel.name] = convert(as_floats(values, column_name(channel.source), copy=False))
    if channel_map.keep_others:
        columns |= _kept(table, columns)
        units |= {name: stated[name] or "" for name in table.columns if stated.get(name)}
    if channel_map.time.rate is not None:
        samples = len(next(iter(columns.values()), ()))
        columns = {TIME: np.arange(samples) / channel_map.time.rate, **columns}
    check_lengths(columns, table.rows)
    meta = _meta(table.meta, channel_map, units)
    made = repaired(Table(columns, meta, table.rows, said=table.said), (*channel_map.repair, *repairs))
    made = undelayed(made, {channel.name: channel.delay for channel in channel_map.channels if channel.delay})
    couple(made.columns, channel_map.couplings)
    for name, expression in channel_map.computed:
        check_names(expression, {x: None for x in made.columns if x != TIME}, f"computed.{name}")
        made.columns[name] = expression.value(made.columns)
    made.columns[TIME] = clocked(channel_map.time, made.columns[TIME])
    return made


class _Raw:
    """The raw columns; each is released after its last use."""

    def __init__(self, table: Table, channel_map: ChannelMap) -> None:
        sources = [channel.source for channel in channel_map.channels]
        if channel_map.time.rate is None:
            sources.append(channel_map.time.source)
        self._columns = table.columns
        self._known = tuple(table.columns)
        self._uses = Counter(map(column_name, sources))

    def take(self, source: str | int, key: str) -> npt.NDArray[Any]:
        """A raw column of the file.

        Raises:
            InputError: there is no column of that name.
        """
        name = column_name(source)
        check_known(name, self._known, "the file has no such column", key=key, value=source, channel=name)
        self._uses[name] -= 1
        return self._columns[name] if self._uses[name] else self._columns.pop(name)


def _kept(table: Table, columns: dict[str, Any]) -> dict[str, Array]:
    """Columns that the map does not name, as they are."""
    for name in table.columns:
        if name in columns or name == TIME:
            remedy = "name the file's column in channels as well, or give others: drop"
            raise InputError("the map makes a channel that the file has too", key="others", value=name, remedy=remedy)
    return {name: as_floats(values, name, copy=False) for name, values in table.columns.items()}


def _meta(meta: dict[str, Any], channel_map: ChannelMap, units: dict[str, str]) -> dict[str, Any]:
    """The meta data of the file and the map; maps that were applied before are kept."""
    known = {key: value for key, value in meta.items() if key not in ("units", "map")}
    if "map" in meta:
        known["earlier_maps"] = [*meta.get("earlier_maps", ()), meta["map"]]
    if channel_map.prescribed:
        known["prescribed"] = [*channel_map.prescribed]
    return known | {"map": channel_map.to_dict()} | ({"units": units} if units else {})


def with_times(time: TimeSource, raw: npt.NDArray[Any], stated: Mapping[str, str | None]) -> Array:
    """A raw column of time in seconds; nanoseconds since 1970 are exact if the first one is subtracted.

    Raises:
        InputError: contradictory units, units that are no times, or integers that doubles cannot represent.
    """
    name = column_name(time.source)
    unit = UNITS[_time_unit(time, stated.get(name, ""))]
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
    """The times from the requested start, shifted.

    Args:
        time: what the map says of the clock.
        t: times in the file [s].
    """
    if time.start == "zero" and len(t):
        t = t - t[0]
    return t + time.shift if time.shift else t


def _time_unit(time: TimeSource, stated: str | None) -> str:
    """The valid unit: the map's, else the file's, else s."""
    unit = valid_unit(time.unit, stated, "time.unit") or "s"
    if time.unit is None and (stated is None or UNITS.get(unit, UNITS["m"]).quantity != "time"):
        problem = "the file states a unit of time that is not known"
        raise InputError(problem, key="time.unit", value=stated, remedy="give s, ms, us, ns, min or h")
    return unit
