"""Units in a channel map: the valid unit of each channel, and the kind of its joint."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from flexdyn.errors import InputError
from flexdyn.records.channelmap.convert import Conversion, conversion
from flexdyn.records.channelmap.description import Channel, ChannelMap, column_name
from flexdyn.records.channelmap.known_units import SLIDING
from flexdyn.records.table import Table
from flexdyn.records.units import PRISMATIC, SIGNALS, split_name


def conversions_of(channel_map: ChannelMap, stated: Mapping[str, str | None]) -> list[Conversion]:
    """The conversions to SI, channel by channel.

    Args:
        channel_map: what the columns mean.
        stated: units that the file states, by column.

    Raises:
        InputError: as `conversion`, or an unreadable unit in the file.
    """
    return [_conversion(channel, stated) for channel in channel_map.channels]


def stated_units(table: Table) -> dict[str, str | None]:
    """Units in the file, with the columns or in its meta data."""
    units = table.meta.get("units", {})
    stated = {str(name): str(unit) for name, unit in units.items()} if isinstance(units, dict) else {}
    return {**stated, **table.units}


def _conversion(channel: Channel, stated: Mapping[str, str | None]) -> Conversion:
    unit = stated.get(column_name(channel.source), "")
    if unit is None and channel.unit is None and channel.factor is None:
        problem = "the file states the column's unit in a way that is not read"
        raise InputError(problem, key=f"channels.{channel.name}.unit", value=channel.source, remedy="state it here")
    return conversion(channel, unit or None)


def units_of(channel_map: ChannelMap, conversions: Sequence[Conversion]) -> dict[str, str]:
    """Units that the channels' names do not determine: of prismatic joints, and of channels that are no signals.

    Raises:
        InputError: a joint is prismatic by one of its units and revolute by another.
    """
    told: dict[str, tuple[bool, str]] = {joint: (True, f"joints.{joint}") for joint in channel_map.prismatic}
    for channel, convert in zip(channel_map.channels, conversions, strict=True):
        slides = convert.quantity in SLIDING.values()
        if channel.signal and (slides or convert.quantity in SLIDING):
            before, by = told.setdefault(channel.joint, (slides, channel.name))
            if before != slides:
                problem = f"the joint {'slides' if before else 'turns'} by {by}, and {convert.unit} says otherwise"
                remedy = "give units of one kind; a rotary motor of a prismatic joint has side: motor"
                raise InputError(problem, key=f"channels.{channel.name}.unit", value=channel.unit, remedy=remedy)
    units = {}
    for channel, convert in zip(channel_map.channels, conversions, strict=True):
        slides = told.get(channel.joint, (False, ""))[0] and (bool(channel.signal) or channel.side == "motor")
        unit = SIGNALS.get(channel.signal, convert.unit)
        unit = PRISMATIC.get(unit, unit) if slides else unit
        if unit and unit != SIGNALS.get(channel.signal):
            units[channel.name] = unit
    for name, _ in channel_map.computed:
        signal, joint = split_name(name) or ("", "")
        if signal and told.get(joint, (False, ""))[0]:
            unit = SIGNALS[signal]
            units[name] = PRISMATIC.get(unit, unit)
    return units
