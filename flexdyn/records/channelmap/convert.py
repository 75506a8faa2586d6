"""The linear conversion from raw columns to channels in SI: the valid unit of each, and the kind of its joint."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from flexdyn.arrays import Array
from flexdyn.errors import InputError, did_you_mean
from flexdyn.records.channelmap.description import Channel, ChannelMap, column_name
from flexdyn.records.channelmap.known_units import ELECTRICAL, SI, SLIDING, UNITS, Unit, plain_unit
from flexdyn.records.table import Table
from flexdyn.records.units import SIGNALS, UNITLESS, signal_unit, split_name, unit_for


@dataclass(frozen=True)
class Conversion:
    """value = raw * numerator / denominator + offset.

    Attributes:
        numerator: with the sign.
        denominator: positive.
        offset: in the channel's SI unit.
        quantity: of the raw unit; empty if the unit does not determine it.
        unit: SI unit of the values, if the raw unit determines it.
    """

    numerator: float
    denominator: float
    offset: float
    quantity: str
    unit: str

    def __call__(self, raw: Array) -> Array:
        """The channel's values, a new array; numbers that are in SI already do not change, bit for bit."""
        values = raw * self.numerator
        if self.denominator != 1.0:
            values /= self.denominator
        if self.offset != 0.0:
            values += self.offset
        return values


def conversion(channel: Channel, stated: str | None) -> Conversion:
    """The conversion of a channel's entry in a map: sign * (raw in SI) [/ or * gear ratio] + offset.

    Args:
        channel: the entry.
        stated: unit of the column in the file; the map may repeat it but not contradict it. Empty: there is none;
            None: it cannot be read.

    Returns:
        The conversion.

    Raises:
        InputError: a unit that is unknown, cannot be read or does not fit the signal, or a missing number.
    """
    if stated is None and channel.unit is None and channel.factor is None:
        problem = "the file states the column's unit in a way that is not read"
        raise InputError(problem, key=_key(channel, "unit"), value=channel.source, remedy="state it here")
    name = valid_unit(channel.unit, stated, _key(channel, "unit"))
    unit = _channel_unit(channel, name)
    label = SI[unit.quantity] if unit.quantity else "" if channel.factor is not None else name
    numerator, denominator = channel.sign * unit.numerator, unit.denominator
    if name.partition("/")[0] == "counts" and channel.factor is None and channel.full_counts is None:
        denominator *= _needed(channel, "counts_per_turn", f"unit: {name}")
    quantity = unit.quantity or _quantity(channel.signal)
    if quantity == "current" and channel.signal and channel.factor is None:
        numerator *= _needed(channel, "torque_constant", f"unit: {name}")
        quantity = "torque"
    told = unit.quantity
    if channel.side == "motor":
        ratio = _needed(channel, "gear_ratio", "side: motor")
        if quantity in ("torque", "force"):
            numerator *= ratio
        elif quantity in ("angle", "length", "angular velocity", "velocity"):
            denominator *= ratio
        else:
            key, remedy = _key(channel, "side"), "it fits positions, velocities and torques: leave it out"
            raise InputError("a gear does not change this channel", key=key, value="motor", remedy=remedy)
        # A rotary motor can drive a prismatic joint too, so its angles do not determine the kind of the joint.
        told = "" if told in SLIDING else told
    return Conversion(numerator, denominator, unit.zero * channel.sign + channel.offset, told, label)


def valid_unit(given: str | None, stated: str | None, key: str) -> str:
    """The map's unit of a column, else the file's; empty if there is none.

    Args:
        given: unit in the map.
        stated: unit in the file.
        key: path of the unit in the map, for the error.

    Raises:
        InputError: they contradict each other.
    """
    unit = "" if given is None else plain_unit(given)
    found = "" if stated is None or stated.strip() in UNITLESS else plain_unit(stated)
    if unit and found and unit != found:
        remedy = f"the file says {stated!r}: give that, or leave unit out"
        raise InputError("not the unit that the file states", key=key, value=given, remedy=remedy)
    return unit or found


def _channel_unit(channel: Channel, name: str) -> Unit:
    """The unit of a channel, by name, factor or full scale; refuses one that does not fit the channel's signal."""
    if channel.full_counts is not None or channel.full_scale is not None:
        return _converter(channel, name)
    signal, unit = channel.signal, UNITS.get(name)
    fitting = _fitting(signal) if signal else tuple(SI)
    if channel.factor is not None:
        raw = unit is not None and unit.quantity in ELECTRICAL and signal != "voltage"  # the factor says what it drives
        if unit is not None and unit.quantity in fitting and not raw:
            key, remedy = _key(channel, "factor"), "leave one of them out"
            raise InputError("factor and unit both give the scale", key=key, value=name, remedy=remedy)
        return Unit("", channel.factor)
    return _unit_named(channel, name)


def _unit_named(channel: Channel, name: str) -> Unit:
    """A unit by its name; SI if it has none."""
    signal, unit = channel.signal, UNITS.get(name)
    fitting = _fitting(signal) if signal else tuple(SI)
    if not name or (unit is None and not signal):
        return Unit("")
    if unit is None or unit.quantity not in fitting:
        problem = "no such unit" if unit is None else f"a unit of {unit.quantity} does not fit {channel.name}"
        known = [other for other, entry in UNITS.items() if entry.quantity in fitting]
        remedy = f"{did_you_mean(name, known)} or give factor, in SI per raw unit"
        raise InputError(problem, key=_key(channel, "unit"), value=channel.unit or name, remedy=remedy)
    return unit


def _converter(channel: Channel, name: str) -> Unit:
    """Counts of a PWM or an ADC; a unit is that of the full scale, such as A of a current that drives a torque."""
    if channel.factor is not None:
        problem, key = "full_counts gives the scale already", _key(channel, "full_counts")
        raise InputError(problem, key=key, remedy="leave factor out; the offset may stay")
    counts = _needed(channel, "full_counts", "full_scale")
    of_scale = _unit_named(channel, "" if name == "counts" else name)
    plain_duty = channel.signal == "duty" and not of_scale.quantity
    most = 1.0 if plain_duty else _needed(channel, "full_scale", "full_counts")
    return Unit(of_scale.quantity, most * of_scale.numerator, counts * of_scale.denominator, of_scale.zero)


def _quantity(signal: str) -> str:
    """Quantity of a signal at a revolute joint; empty for a channel that is no signal."""
    return next((quantity for quantity, unit in SI.items() if unit == SIGNALS.get(signal)), "")


def _fitting(signal: str) -> tuple[str, ...]:
    """Quantities that a signal may be measured in."""
    quantity = _quantity(signal)
    found = (quantity, SLIDING[quantity]) if quantity in SLIDING else (quantity,)
    return (*found, "current") if quantity == "torque" else found


def _needed(channel: Channel, number: str, because: str) -> float:
    value: float | None = getattr(channel, number)
    if value is None:
        remedy = f"give it here or as joints.{channel.joint}.{number}" if channel.joint else "give it here"
        raise InputError(f"{because} needs {number}", key=_key(channel, number), remedy=remedy)
    return value


def _key(channel: Channel, entry: str) -> str:
    return f"channels.{channel.name}.{entry}"


def conversions_of(channel_map: ChannelMap, stated: Mapping[str, str | None]) -> list[Conversion]:
    """The conversions to SI, channel by channel.

    Args:
        channel_map: what the columns mean.
        stated: units that the file states, by column.

    Raises:
        InputError: as `conversion`.
    """
    return [conversion(channel, stated.get(column_name(channel.source), "")) for channel in channel_map.channels]


def stated_units(table: Table) -> dict[str, str | None]:
    """Units in the file, with the columns or in its meta data."""
    units = table.meta.get("units", {})
    stated = {str(name): str(unit) for name, unit in units.items()} if isinstance(units, dict) else {}
    return {**stated, **table.units}


def undetermined_units(channel_map: ChannelMap, conversions: Sequence[Conversion]) -> dict[str, str]:
    """Units that the channels' names do not determine: of prismatic joints, and of channels that are no signals.

    Args:
        channel_map: of the file.
        conversions: of its channels, in their order.

    Returns:
        Units by channel.

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
        unit = unit_for(SIGNALS.get(channel.signal, convert.unit), prismatic=slides)
        if unit and unit != SIGNALS.get(channel.signal):
            units[channel.name] = unit
    for name, _ in channel_map.computed:
        signal, joint = split_name(name) or ("", "")
        if signal and told.get(joint, (False, ""))[0]:
            units[name] = signal_unit(signal, prismatic=True)
    return units
