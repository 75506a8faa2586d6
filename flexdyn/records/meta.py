"""Meta data of a recording: plain JSON, read-only; and the units that a file states, which it keeps."""

from __future__ import annotations

import json
from collections.abc import Collection, Mapping
from typing import Any

import numpy as np

from flexdyn.checks import check_known
from flexdyn.errors import InputError
from flexdyn.io.locked import frozen
from flexdyn.records.table import Table
from flexdyn.records.units import UNITLESS, check_unit, split_name, unit_of, usual

_LONGEST_META = 16 * 2**20


def locked(meta: Mapping[str, Any] | None) -> Mapping[str, Any]:
    """A read-only deep copy of JSON-able data: mappings become read-only mappings, lists and tuples become tuples.

    Args:
        meta: strings, finite numbers, booleans, None, lists and mappings of them; NumPy's arrays and scalars too.

    Returns:
        The copy.

    Raises:
        InputError: it is no mapping, contains something that JSON does not have (such as NaN), or is longer than 16
            MiB.
    """
    if meta is not None and not isinstance(meta, Mapping):
        raise InputError("meta is not a mapping", key="meta", value=meta)
    try:
        locked_meta: Mapping[str, Any] = frozen(as_plain(meta or {}))
        return locked_meta
    except InputError:
        raise
    except (TypeError, ValueError, RecursionError) as error:
        remedy = "give strings, finite numbers, lists and mappings"
        raise InputError(f"meta cannot be written as JSON ({error})", key="meta", remedy=remedy) from None


def as_json(meta: Mapping[str, Any]) -> str:
    """JSON text, in ASCII, of data that `locked` accepts or returns.

    Raises:
        InputError: it is longer than 16 MiB.
    """
    text = json.dumps(meta, default=_plain_value, allow_nan=False)
    if len(text) > _LONGEST_META:
        raise InputError("meta is longer than 16 MiB", key="meta", remedy="keep long data in channels")
    return text


def as_plain(meta: Mapping[str, Any]) -> dict[str, Any]:
    """A deep copy in plain dictionaries and lists, free to change."""
    return dict(json.loads(as_json(meta)))


def from_json(text: str) -> dict[str, Any]:
    """Read meta data from a file's text.

    Raises:
        InputError: the text is not JSON, or not a mapping.
    """
    try:
        meta = json.loads(text) if len(text) <= _LONGEST_META else None
    except (ValueError, RecursionError):
        meta = None
    if not isinstance(meta, dict):
        raise InputError("meta is not a JSON object of up to 16 MiB", key="meta", value=text)
    return meta


def _plain_value(value: Any) -> Any:
    if isinstance(value, Mapping):
        return dict(value)
    if isinstance(value, np.ndarray | np.generic):
        return value.tolist()
    raise TypeError(f"{type(value).__name__} is not JSON")


def settle_units(table: Table) -> None:
    """Keep in meta the units that the channels' names do not determine.

    Args:
        table: whose ``units`` are removed; a channel map, if there is one, has used them before.

    Raises:
        InputError: a unit is not SI, so that the numbers would be misread.
    """
    for name, stated in table.units.items():
        if stated is None:
            problem = "the file states the unit in a way that is not read"
            raise InputError(problem, remedy="state it in a channel map", channel=name)
        unit, units = usual(stated), table.meta.get("units", {})
        if unit in UNITLESS:
            continue
        check_unit(name, unit)
        if isinstance(units, dict) and unit != unit_of(name, units if isinstance(units.get(name, ""), str) else None):
            table.meta["units"] = {**units, name: unit}
    table.units = {}


def check_units(units: Any, channels: Collection[str]) -> None:
    """Check ``meta["units"]`` against the channels.

    Raises:
        InputError: it is no mapping of channels to units in SI.
    """
    if not isinstance(units, Mapping) or not all(isinstance(unit, str) for unit in units.values()):
        raise InputError("units is not a mapping of channel to unit", key="meta.units", value=units)
    for channel, unit in units.items():
        check_known(channel, channels, "no such channel", key=f"meta.units.{channel}")
        check_unit(channel, unit)


def check_prescribed(joints: Any, channels: Collection[str]) -> None:
    """Check ``meta["prescribed"]`` against the channels.

    Raises:
        InputError: it is no list of joints that have a channel.
    """
    if not isinstance(joints, tuple) or not all(isinstance(joint, str) for joint in joints):
        raise InputError("a list of joints is needed", key="meta.prescribed", value=joints, remedy='such as ["slide"]')
    known = {parts[1] for parts in map(split_name, channels) if parts}
    for joint in joints:
        check_known(joint, known, "no channel of this joint", key="meta.prescribed", value=joint)
