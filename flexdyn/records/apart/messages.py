"""Messages from the reading process to the caller: JSON with its length in front, and the bytes of columns.

No answer is trusted: a damaged file may have changed the process that read it in any way.
"""

from __future__ import annotations

import json
import os
from io import BufferedReader
from typing import Any

import numpy as np

from flexdyn.errors import InputError
from flexdyn.records.bounds import check_size
from flexdyn.records.table import Rows, Table

_LONGEST_MESSAGE = 2**26
_STRANGE = (ValueError, KeyError, TypeError, AttributeError, RecursionError)


class Lost(Exception):
    """The other process has ended, or its message is not valid."""


def send(out: int, kind: str, content: Any) -> None:
    """Write one message.

    Args:
        out: file descriptor.
        kind: what it is: ``ready``, ``progress``, ``error``, ``memory`` or ``table``.
        content: data for JSON.
    """
    text = json.dumps({kind: content}, default=str).encode()
    _write(out, len(text).to_bytes(8, "little") + text)


def send_table(out: int, table: Table) -> None:
    """Write a table, followed by the bytes of its columns."""
    columns = {name: np.ascontiguousarray(values) for name, values in table.columns.items()}
    about = {
        "columns": [[name, values.dtype.str, len(values)] for name, values in columns.items()],
        "meta": table.meta,
        "rows": [table.rows.word, table.rows.first],
        "units": table.units,
        "said": table.said,
    }
    send(out, "table", about)
    for values in columns.values():
        _write(out, values.view(np.uint8).data)


def received(stream: BufferedReader) -> tuple[str, Any]:
    """Read one message.

    Raises:
        Lost: the other process has ended, or the data are no message.
    """
    length = int.from_bytes(_exactly(stream, 8), "little")
    if length > _LONGEST_MESSAGE:
        raise Lost
    try:
        ((kind, content),) = json.loads(_exactly(stream, length)).items()
    except _STRANGE:
        raise Lost from None
    return kind, content


def received_table(stream: BufferedReader, about: Any, on_disk: int) -> Table:
    """Read the table of a message, with the columns that follow it.

    Args:
        stream: from which the message came.
        about: content of the message.
        on_disk: bytes of the file.

    Raises:
        Lost: the other process has ended, or the data are no table, or larger than the file can be.
    """
    try:
        columns = [(str(name), np.dtype(str(kind)), int(count)) for name, kind, count in about["columns"]]
        if any(kind.kind not in "fiub" or kind.itemsize > 8 or count < 0 for _, kind, count in columns):
            raise Lost
        check_size(sum(kind.itemsize * count for _, kind, count in columns), on_disk)
        word, first = about["rows"]
        table = Table(meta=dict(about["meta"]), rows=Rows(str(word), int(first)))
        table.units = {str(name): None if unit is None else str(unit) for name, unit in about["units"].items()}
        table.said = [str(text) for text in about["said"]]
        for name, kind, count in columns:
            values = np.empty(count, kind)
            if stream.readinto(values.view(np.uint8).data) < values.nbytes:
                raise Lost
            table.add(name, values)
    except _STRANGE:
        raise Lost from None
    return table


def received_error(content: Any) -> InputError:
    """The error in a message.

    Raises:
        Lost: the message has none.
    """
    try:
        data = {str(name): value for name, value in content.items()}
        return InputError(str(data.pop("problem")), **data)
    except _STRANGE:
        raise Lost from None


def _write(out: int, data: bytes | memoryview) -> None:
    left = memoryview(data)
    while left:
        left = left[os.write(out, left) :]


def _exactly(stream: BufferedReader, count: int) -> bytes:
    data = stream.read(count)
    if len(data) < count:
        raise Lost
    return data
