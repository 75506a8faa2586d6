"""Parquet: one column of doubles per channel and ``t``, as pandas and polars write them.

Each field carries its unit as ``units`` in its metadata, and the schema carries meta as ``__meta__``.
"""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

import numpy as np

from flexdyn.arrays import Array
from flexdyn.errors import InputError, needed
from flexdyn.records.bounds import check_count, check_size
from flexdyn.records.meta import as_json, from_json
from flexdyn.records.recording import Recording
from flexdyn.records.request import Request
from flexdyn.records.table import RESERVED, Table, as_floats, check_name, check_new, check_time_named, damage_named

_ROWS_AT_ONCE = 2**20
_PANDAS_LABELS = "__index_level_"


def write(rec: Recording, path: Path) -> None:
    """Write row groups of a million samples, each page with its checksum.

    Args:
        rec: the recording.
        path: of the new file.
    """
    pa, pq = _pyarrow()
    columns = {"t": rec.t, **rec.channels}
    fields = [pa.field(name, pa.float64(), nullable=False, metadata={"units": rec.unit(name)}) for name in columns]
    schema = pa.schema(fields, metadata={RESERVED: as_json(rec.meta)} if rec.meta else None)
    settings = {"use_dictionary": False, "compression": "snappy", "write_page_checksum": True}
    with open(path, "xb") as stream, pq.ParquetWriter(stream, schema, **settings) as writer:
        for start in range(0, len(rec), _ROWS_AT_ONCE):
            rows = [pa.array(values[start : start + _ROWS_AT_ONCE]) for values in columns.values()]
            writer.write_table(pa.Table.from_arrays(rows, schema=schema))


def read(path: Path, request: Request) -> Table:
    """Read column by column and row group by row group; memory holds the numbers once, and a row group of one column.

    Labels of rows from pandas (``__index_level_0__``) are left out unless requested.

    Args:
        path: of the file.
        request: what is wanted, and how the file is laid out.

    Raises:
        InputError: not a Parquet file, truncated, types other than numbers, missing values, impossible sizes.
        MissingExtra: pyarrow is not installed.
    """
    pa, pq = _pyarrow()
    table = Table()
    with open(path, "rb") as stream:
        with damage_named("not a Parquet file, or truncated"):
            file = pq.ParquetFile(stream, page_checksum_verification=True, pre_buffer=False)
            schema, rows = file.schema_arrow, _rows_in_groups(file)
        check_count(len(schema.names))
        names = _names(schema.names, request)
        check_size(sum(rows) * 8 * len(names), os.path.getsize(path))
        for name in names:
            _check_type(pa, schema.field(name).type, name)
        if RESERVED.encode() in (schema.metadata or {}):
            table.meta = from_json(schema.metadata[RESERVED.encode()].decode("utf-8", "replace"))
        for place, name in enumerate(names):
            with damage_named(f"the column {name} cannot be read"):
                table.add(name, _whole_column(file, name, rows))
            table.units[name] = (schema.field(name).metadata or {}).get(b"units", b"").decode("utf-8", "replace")
            request.report((place + 1) / len(names))
    return table


def _pyarrow() -> tuple[Any, Any]:
    with needed("pyarrow", "parquet"):
        import pyarrow
        import pyarrow.parquet
    return pyarrow, pyarrow.parquet


def _rows_in_groups(file: Any) -> list[int]:
    rows = [file.metadata.row_group(group).num_rows for group in range(file.metadata.num_row_groups)]
    if min(rows, default=0) < 0 or sum(rows) != file.metadata.num_rows:
        raise InputError("the numbers of rows in the file do not add up", remedy="the file is damaged")
    return rows


def _names(there: list[str], request: Request) -> list[str]:
    """Columns to be read, in the order of the file."""
    names = request.chosen(there)
    if request.columns is None:
        names = [name for name in names if not name.startswith(_PANDAS_LABELS)]
    if not request.mapped:
        check_time_named(names)
        for name in names:
            if name != "t":
                check_name(name)
    for place, name in enumerate(names):
        check_new(name, names[:place])
    return names


def _check_type(pa: Any, kind: Any, name: str) -> None:
    """Refuse a column that has no numbers, before it is read."""
    if pa.types.is_floating(kind) or pa.types.is_integer(kind) or pa.types.is_boolean(kind):
        return
    remedy = "give real numbers"
    if pa.types.is_nested(kind):
        remedy = "write one flat column per channel"
    elif pa.types.is_temporal(kind):
        remedy = "write seconds as doubles, in pandas: (time - time[0]).dt.total_seconds()"
    raise InputError(f"the column holds {kind}, not doubles", remedy=remedy, channel=name)


def _whole_column(file: Any, name: str, rows: list[int]) -> Array:
    """One column from all row groups."""
    values = np.empty(sum(rows))
    begin = 0
    for group, count in enumerate(rows):
        for chunk in file.read_row_group(group, columns=[name], use_threads=False).column(name).chunks:
            # A missing value is NaN, and a repair treats it like any NaN (pandas writes NaN in this way).
            known = chunk.is_valid().to_numpy(zero_copy_only=False)
            there = values[begin : begin + len(chunk)]
            there[known] = as_floats(chunk.drop_null().to_numpy(zero_copy_only=False), name, copy=False)
            there[~known] = np.nan
            begin += len(chunk)
        if begin != sum(rows[: group + 1]):
            remedy = "the file is damaged"
            raise InputError(f"not the {count} rows that row group {group} announces", key=name, remedy=remedy)
    return values
