"""Recordings as pandas data frames, and back without loss."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from flexdyn.errors import InputError, needed
from flexdyn.records.channelmap.known_units import split_unit
from flexdyn.records.meta import as_plain
from flexdyn.records.recording import Recording
from flexdyn.records.table import Table
from flexdyn.records.units import split_name

ATTRIBUTE = "flexdyn"
"""Key of a frame's attrs under which meta and name are kept."""


def to_frame(rec: Recording) -> Any:
    """A frame whose index is ``t`` [s] and whose columns are the channels.

    Raises:
        MissingExtra: pandas is not installed.
    """
    with needed("pandas", "pandas"):
        import pandas
    frame = pandas.DataFrame(dict(rec.channels), index=pandas.Index(rec.t, name="t"), copy=True)
    frame.attrs[ATTRIBUTE] = {"name": rec.name, "meta": as_plain(rec.meta)}
    return frame


def table_of_frame(frame: Any) -> tuple[Table, str]:
    """The raw table of a frame, and its name.

    Raises:
        InputError: it is no frame, or a column has no numbers.
    """
    if type(frame).__name__ != "DataFrame" or not hasattr(frame, "columns"):
        raise InputError("a pandas.DataFrame is needed", key="frame", value=type(frame).__name__)
    kept = frame.attrs.get(ATTRIBUTE, {}) if isinstance(frame.attrs.get(ATTRIBUTE), dict) else {}
    table = Table(meta=as_plain(kept.get("meta", {})))
    columns = {_name(label): frame.iloc[:, place] for place, label in enumerate(frame.columns)}
    if len(columns) != frame.shape[1]:
        raise InputError("several columns have one name", key="frame", remedy="rename or remove one")
    if not any(_label_channel(name)[0] == "t" for name in columns):
        table.add("t", _index_times(frame.index, table))
    for name, column in columns.items():
        key, unit = _label_channel(name)
        table.add(key, _index_times(column, table) if key == "t" else _column_numbers(column, name))
        if unit:
            table.units[key] = unit
    return table, str(kept.get("name", ""))


def _name(label: Any) -> str:
    """A column's label; those of two levels, signal and joint, are joined."""
    return ".".join(map(str, label)) if isinstance(label, tuple) else str(label)


def _label_channel(name: str) -> tuple[str, str]:
    """Channel and unit that a column's name states."""
    bare, unit = split_unit(name)
    return (bare, unit) if unit and (bare == "t" or split_name(bare)) else (name, "")


def _index_times(values: Any, table: Table) -> npt.NDArray[Any]:
    """Times in seconds; dates are counted from the first, which meta keeps as ``start_ns``."""
    kind = getattr(values.dtype, "kind", "O")
    if kind == "M":
        stamps = values.to_numpy(dtype="datetime64[ns]").astype(np.int64)  # with a zone: UTC
        if len(stamps):
            table.meta["start_ns"] = int(stamps[0])
        return np.asarray((stamps - stamps[:1]) / 1e9)
    if kind == "m":
        return np.asarray(values.to_numpy(dtype="timedelta64[ns]").astype(np.int64) / 1e9)
    return _column_numbers(values, "t")


def _column_numbers(values: Any, name: str) -> npt.NDArray[Any]:
    """A column as doubles, NaN where pandas has no value."""
    try:
        return np.array(values.to_numpy(dtype=np.float64, na_value=np.nan))
    except (TypeError, ValueError):
        raise InputError("the column holds no numbers", remedy="convert or drop the column", channel=name) from None
