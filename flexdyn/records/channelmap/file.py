"""map.yaml -> ChannelMap, validated: every mistake is one line that names file, key and remedy.

An example of all entries; `Channel`, `TimeSource`, `Coupling` and `Layout` explain their meaning::

    flexdyn_map: 1
    source: {names_line: 13, first_line: 15, delimiter: ";", decimal: ",", encoding: latin-1}  # of text
    # source: {topic: /joint_states, clock: message}                                                   # of a bag
    time: {from: stamp, unit: ms, start: zero, shift: 0.012}   # or {rate: 1000} where no column holds the time
    joints:                                        # numbers that the channels of a joint share
      elbow: {gear_ratio: 100, torque_constant: 0.05}
      slide: {prismatic: true}                     # where no unit of length or force says it
    channels:
      q.elbow: {from: pos_meas1, unit: deg, sign: -1, offset: 0.2}
      theta.elbow: {from: enc1, unit: counts, counts_per_turn: 131072, side: motor}
      tau.elbow: {from: i1, unit: A, side: motor}
      q.slide: 4                                   # column 4, in SI already
      tau.slide: {from: vir, unit: V, factor: 35.15, delay: 0.002}
      duty.wrist: {from: pwm, full_counts: 885}    # PWM counts at full voltage
      voltage.arm: {from: adc, full_counts: 4095, full_scale: 24, offset: -12}  # counts of an ADC, 0 V at half of them
      tau.arm: {from: i, full_counts: 2048, full_scale: 10, unit: A, torque_constant: 0.05}  # counts of a current
      theta.pitch: m1                              # motors of a differential wrist
      theta.roll: m2
    computed:                                      # of channels above, in SI, with + - * / and brackets
      twist: 0.5 * (theta.pitch + theta.roll) - q.elbow
    couplings:                                     # torque left out: the inverse transpose, which keeps the power
      - {joints: [pitch, roll], position: [[0.5, 0.5], [0.5, -0.5]], signals: [theta, omega]}
    prescribed: [slide]                            # joints whose motion a test rig prescribes; tau is the rig's force
    others: drop                                   # or keep
    repair: [sort_time, {fill_nan: {longest: 0.5}}]
"""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import fields
from pathlib import Path
from typing import Any

from flexdyn.checks import check_known
from flexdyn.errors import InputError, placed, retold
from flexdyn.io.yaml import check_format, check_keys, read_yaml
from flexdyn.records.channelmap.convert import conversions_of, undetermined_units
from flexdyn.records.channelmap.couplings import couplings_of
from flexdyn.records.channelmap.description import MAP_FORMAT, Channel, ChannelMap
from flexdyn.records.channelmap.expression import Expression, check_names, expression_of
from flexdyn.records.channelmap.known_units import UNITS, plain_unit
from flexdyn.records.channelmap.values import (
    POSITIVE,
    as_choice,
    as_finite,
    as_text,
    checked_column,
    layout_of,
    time_of,
)
from flexdyn.records.repairs import repairs_of
from flexdyn.records.table import check_name
from flexdyn.records.units import SIGNALS

TOP_KEYS = ("source", "time", "joints", "channels", "computed", "couplings", "prescribed", "others", "repair")
CHANNEL_KEYS = tuple("from" if item.name == "source" else item.name for item in fields(Channel) if item.name != "name")
JOINT_KEYS = ("gear_ratio", "torque_constant", "counts_per_turn", "prismatic")


def read_map(path: str | os.PathLike[str]) -> ChannelMap:
    """Read a channel map.

    Args:
        path: of a YAML file with ``flexdyn_map: 1``.

    Returns:
        The map, for ``read_recording(..., map=...)``.

    Raises:
        InputError: no such file, or an entry in it that does not fit.

    Example:
        >>> with open("map.yaml", "w") as file:
        ...     _ = file.write("{flexdyn_map: 1, time: stamp, channels: {q.elbow: {from: enc, unit: deg}}}")
        >>> fd.read_map("map.yaml").repair
        ()
    """
    try:
        file = Path(path)
    except TypeError:
        raise InputError("the path of a map file is needed", key="map", value=path) from None
    with placed(file=file):
        return map_from_dict(read_yaml(file))


def map_from_dict(content: Mapping[str, Any]) -> ChannelMap:
    """Make the map that a file's mapping describes.

    Raises:
        InputError: a key, unit or number that does not fit.
    """
    check_format(content, "flexdyn_map", MAP_FORMAT, TOP_KEYS)
    entry = {key: value for key, value in content.items() if value is not None}
    keep = as_choice("others", entry.get("others", "drop"), ("drop", "keep")) == "keep"
    channels, prismatic = _map_channels(entry.get("channels", {}), entry.get("joints", {}))
    if not channels and not keep:
        raise InputError("no channels", key="channels", remedy="name one as q.elbow: COLUMN, or give others: keep")
    made = ChannelMap(
        channels,
        time_of(entry.get("time", {})),
        couplings_of(entry.get("couplings", []), channels),
        prismatic,
        keep,
        repairs_of(entry.get("repair", [])),
        layout_of(entry.get("source", {})),
        _computed(entry.get("computed", {}), channels, keep=keep),
        _prescribed(entry.get("prescribed", []), channels, keep=keep),
    )
    _check_numbered(made)
    undetermined_units(made, conversions_of(made, {}))  # and again with the units in the file when they are known
    return made


def _check_numbered(made: ChannelMap) -> None:
    """Check that all columns are given by name: other columns are kept under their names."""
    sources = {f"channels.{channel.name}.from": channel.source for channel in made.channels}
    for key, source in {"time.from": made.time.source, **sources}.items():
        if made.keep_others and isinstance(source, int):
            remedy = "give the column's name, or others: drop"
            raise InputError("a column by number does not go with others: keep", key=key, value=source, remedy=remedy)


def _map_channels(entries: Any, joints: Any) -> tuple[tuple[Channel, ...], tuple[str, ...]]:
    """Channels with the numbers of their joints, and the joints that are declared prismatic."""
    check_keys(entries, list(entries) if isinstance(entries, Mapping) else (), key="channels")
    for name in entries:
        _check_channel_name(name)
    known = tuple(dict.fromkeys(name.partition(".")[2] for name in entries if "." in name))
    check_keys(joints, known, key="joints")
    shared = {joint: _joint(joint, numbers) for joint, numbers in joints.items()}
    channels = tuple(
        _map_channel(name, entry, shared.get(name.partition(".")[2], {})) for name, entry in entries.items()
    )
    return channels, tuple(joint for joint, numbers in shared.items() if numbers.get("prismatic"))


def _computed(entries: Any, channels: tuple[Channel, ...], *, keep: bool) -> tuple[tuple[str, Expression], ...]:
    """Computed channels with their expressions of channels before them; with others: keep, also those of the file."""
    check_keys(entries, list(entries) if isinstance(entries, Mapping) else (), key="computed")
    known = [channel.name for channel in channels]
    found = []
    for name, text in entries.items():
        key = f"computed.{name}"
        _check_channel_name(name, "computed")
        if name in known:
            remedy = "give it another name in channels: it is kept under that name"
            raise InputError("the channel is there already", key=key, value=text, remedy=remedy)
        expression = expression_of(text, key)
        if not keep:
            check_names(expression, tuple(known), key)
        found.append((name, expression))
        known.append(name)
    return tuple(found)


def _prescribed(joints: Any, channels: tuple[Channel, ...], *, keep: bool) -> tuple[str, ...]:
    """Joints whose motion a test rig prescribes, each with a channel; with others: keep, maybe one of the file."""
    if not isinstance(joints, list) or not all(isinstance(joint, str) for joint in joints):
        remedy = "give a list of joints, such as [slide]"
        raise InputError("a list of joints is needed", key="prescribed", value=joints, remedy=remedy)
    known = tuple(dict.fromkeys(channel.joint for channel in channels if channel.signal))
    for joint in joints:
        if not keep:
            check_known(joint, known, "no channel of this joint", key="prescribed", value=joint)
    return tuple(joints)


def _check_channel_name(name: Any, where: str = "channels") -> None:
    with retold(key=where, value=name):
        check_name(name)
    signal, dot, _ = name.partition(".")
    if dot and signal not in SIGNALS and signal.lower() in SIGNALS:
        remedy = f"did you mean '{signal.lower()}'?"
        raise InputError("no such signal", key=f"{where}.{name}", value=signal, remedy=remedy)


def _joint(joint: str, numbers: Any) -> dict[str, Any]:
    """Numbers that the channels of a joint share."""
    key = f"joints.{joint}"
    check_keys(numbers, JOINT_KEYS, key=key)
    given: dict[str, Any] = {name: as_finite(key, name, numbers[name]) for name in POSITIVE if name in numbers}
    if "prismatic" in numbers:
        if not isinstance(numbers["prismatic"], bool):
            raise InputError("true or false is needed", key=f"{key}.prismatic", value=numbers["prismatic"])
        given["prismatic"] = numbers["prismatic"]
    return given


def _map_channel(name: str, entry: Any, shared: Mapping[str, Any]) -> Channel:
    """A channel of a map, with the numbers that its joint shares."""
    key = f"channels.{name}"
    if not isinstance(entry, Mapping):
        entry = {"from": entry}
    check_keys(entry, CHANNEL_KEYS, required=("from",), key=key)
    given: dict[str, Any] = {"source": checked_column(f"{key}.from", entry["from"])}
    for item, value in entry.items():
        if item == "unit":
            given[item] = as_text(f"{key}.unit", value)
        elif item == "side":
            given[item] = as_choice(f"{key}.side", value, ("link", "motor"))
        elif item == "sign":
            if isinstance(value, bool) or value not in (1, -1):
                raise InputError("1 or -1 is needed", key=f"{key}.sign", value=value, remedy="scale with factor")
            given[item] = int(value)
        elif item != "from":
            given[item] = as_finite(key, item, value)
    return Channel(name, **_with_shared(key, given, shared))


def _with_shared(key: str, given: dict[str, Any], shared: Mapping[str, Any]) -> dict[str, Any]:
    """The joint's numbers that the channel uses; its own numbers that it does not use are refused."""
    unit = plain_unit(given["unit"]) if "unit" in given else None
    quantity = UNITS[unit].quantity if unit is not None and unit in UNITS else None
    uses = {
        "gear_ratio": (given.get("side") == "motor", "side: motor"),
        "counts_per_turn": (unit is None or unit.startswith("counts"), "unit: counts"),
        "torque_constant": (unit is None or quantity == "current", "unit: A"),
    }
    for number, (used, where) in uses.items():
        used = used and (number == "gear_ratio" or "factor" not in given)
        if number in given and not used:
            raise InputError("the number is not used", key=f"{key}.{number}", remedy=f"it goes with {where}")
        if used and number in shared:
            given.setdefault(number, shared[number])
    return given
