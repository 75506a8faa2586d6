"""Single values of a channel map, and its entries ``source`` and ``time``, checked."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import fields
from typing import Any

from flexdyn.checks import check_known, number, whole
from flexdyn.errors import InputError
from flexdyn.io.yaml import check_keys
from flexdyn.records.channelmap.description import TIME, TimeSource
from flexdyn.records.channelmap.known_units import UNITS, plain_unit
from flexdyn.records.request import CLOCKS, Layout

POSITIVE = ("gear_ratio", "torque_constant", "counts_per_turn", "full_counts")
"""Numbers that must be positive, because a negative one would hide a reversed sign."""


def as_choice(key: str, value: Any, known: Collection[str]) -> str:
    """Check that a value is one of the allowed words.

    Raises:
        InputError: it is another one.
    """
    check_known(value, known, "no such choice", key=key, value=value)
    return str(value)


def checked_column(key: str, value: Any) -> str | int:
    """Check a column, given by name or number.

    Args:
        key: for the message.
        value: as given.

    Raises:
        InputError: it is neither.
    """
    if isinstance(value, int) and not isinstance(value, bool) and value >= 1:
        return value
    if not isinstance(value, str) or not value:
        raise InputError("the name of a column, or its number from 1, is needed", key=key, value=value)
    return value


def as_text(key: str, value: Any) -> str:
    """Check for a text that is not blank.

    Args:
        key: for the message.
        value: as given.

    Raises:
        InputError: it is something else.
    """
    if not isinstance(value, str) or not value.strip():
        raise InputError("a text is needed", key=key, value=value)
    return value


def as_finite(key: str, name: str, value: Any, *, positive: bool = False) -> float:
    """Check a finite number; some must not be zero, some must be above zero.

    Args:
        key: path of the mapping that contains it.
        name: its key there.
        value: as given.
        positive: whether it must be above zero, as those of `POSITIVE` must.

    Raises:
        InputError: it is not.
    """
    key = f"{key}.{name}"
    found = number(key, value)
    if positive or name in POSITIVE:
        remedy = "a reversed channel has sign: -1" if name in POSITIVE else None
        return number(key, value, "a number above zero is needed", above=0.0, remedy=remedy)
    if name in ("factor", "full_scale") and found == 0:
        raise InputError("a number other than zero is needed", key=key, value=value)
    return found


TIME_KEYS = ("from", "unit", "rate", "start", "shift")
SOURCE_KEYS = tuple(item.name for item in fields(Layout))


def time_of(entry: Any) -> TimeSource:
    """The source of the times, from a map's ``time``.

    Raises:
        InputError: a key, unit or number that does not fit.
    """
    if not isinstance(entry, Mapping):
        entry = {"from": entry}
    check_keys(entry, TIME_KEYS, key="time")
    if "rate" in entry and ("from" in entry or "unit" in entry):
        remedy = "give rate where the file has no column of time, else from and unit"
        raise InputError("rows are counted and read from a column", key="time.rate", remedy=remedy)
    unit = entry.get("unit")
    if unit is not None and UNITS.get(plain_unit(as_text("time.unit", unit)), UNITS["m"]).quantity != "time":
        known = [name for name, known in UNITS.items() if known.quantity == "time"]
        check_known(unit, known, "no unit of time", key="time.unit", value=unit)
    return TimeSource(
        checked_column("time.from", entry.get("from", TIME)),
        unit,
        as_finite("time", "rate", entry["rate"], positive=True) if "rate" in entry else None,
        as_choice("time.start", entry.get("start", "keep"), ("keep", "zero")),
        as_finite("time", "shift", entry.get("shift", 0.0)),
    )


def layout_of(entry: Any) -> Layout:
    """The layout of the file, from a map's ``source``.

    Raises:
        InputError: a key or value that does not fit.
    """
    check_keys(entry, SOURCE_KEYS, key="source")
    given = {name: value for name, value in entry.items() if value is not None}
    for name in ("names_line", "first_line"):
        whole(f"source.{name}", given.get(name, 1), 1, problem="a line number from 1 is needed")
    for name, choices in (("decimal", (".", ",")), ("clock", CLOCKS), ("merge", ("linear", "hold"))):
        as_choice(f"source.{name}", given.get(name, choices[0]), choices)
    if "encoding" in given:
        _check_encoding(given["encoding"])
    delimiter = given.get("delimiter", ",")
    if not isinstance(delimiter, str) or len(delimiter) != 1:
        remedy = 'such as ";" or "\\t"'
        raise InputError("one character is needed", key="source.delimiter", value=delimiter, remedy=remedy)
    if "topic" in given:
        as_text("source.topic", given["topic"])
    return Layout(**given)


def _check_encoding(name: Any) -> None:
    """Refuse an unknown encoding.

    Raises:
        InputError: it is none of Python's text encodings.
    """
    try:
        "a".encode(as_text("source.encoding", name))
    except LookupError:
        remedy = "such as utf-8, latin-1, cp1252 (Windows, Western Europe) or utf-16"
        raise InputError("no such encoding", key="source.encoding", value=name, remedy=remedy) from None
