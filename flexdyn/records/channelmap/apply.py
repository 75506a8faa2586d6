"""Apply a channel map: a file's raw columns become SI channels."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from flexdyn.checks import Array, check_known
from flexdyn.errors import InputError
from flexdyn.records.channelmap.clock import clocked, undelayed, with_times
from flexdyn.records.channelmap.couplings import couple
from flexdyn.records.channelmap.description import TIME, ChannelMap, column_name
from flexdyn.records.channelmap.expression import check_names
from flexdyn.records.channelmap.units import conversions_of, stated_units, units_of
from flexdyn.records.repairs import Repair, repaired
from flexdyn.records.table import Table, as_floats, check_lengths


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
    units = units_of(channel_map, conversions)
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
        columns = {TIME: _counted(columns, channel_map.time.rate), **columns}
    check_lengths(columns, table.rows)
    meta = _meta(table.meta, channel_map, units)
    made = repaired(Table(columns, meta, table.rows), (*channel_map.repair, *repairs))
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


def _counted(columns: dict[str, Array], rate: float) -> Array:
    length = len(next(iter(columns.values()), ()))
    return np.arange(length) / rate


def _meta(meta: dict[str, Any], channel_map: ChannelMap, units: dict[str, str]) -> dict[str, Any]:
    """The meta data of the file and the map; maps that were applied before are kept."""
    known = {key: value for key, value in meta.items() if key not in ("units", "map")}
    if "map" in meta:
        known["earlier_maps"] = [*meta.get("earlier_maps", ()), meta["map"]]
    if channel_map.prescribed:
        known["prescribed"] = [*channel_map.prescribed]
    return known | {"map": channel_map.to_dict()} | ({"units": units} if units else {})
