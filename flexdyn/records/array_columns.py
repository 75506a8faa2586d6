"""Columns of two-dimensional arrays in files that Python writes: ``q[:,0]`` is the first column of ``q``."""

from __future__ import annotations

import re
from collections.abc import Collection, Iterable
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from flexdyn.errors import InputError, did_you_mean
from flexdyn.records.table import check_numbers

_PART = re.compile(r"(?P<array>.+?)\s*\[\s*(?P<row>:|[0-9]{1,9})\s*,\s*(?P<column>:|[0-9]{1,9})\s*\]")


@dataclass(frozen=True)
class RequestedColumn:
    """One requested column.

    Attributes:
        key: as it was requested.
        array: name of the array.
        axis: along which the index counts; None: the array itself is one column.
        index: from 0.
    """

    key: str
    array: str
    axis: int | None = None
    index: int = 0

    def check(self, dtype: np.dtype[Any], shape: tuple[int, ...]) -> None:
        """Refuse an array that has no such column, before any of it is read.

        Args:
            dtype: of the array.
            shape: of the array.

        Raises:
            InputError: naming the column and how to write it.
        """
        if self.axis is None:
            if len(shape) == 2:
                remedy = f"a channel map takes one of its columns as {self.array}[:,0] or rows as {self.array}[0,:]"
                raise InputError(f"the column has the shape {shape}", remedy=remedy, channel=self.key)
            check_numbers(dtype, shape, self.key)
            return
        if len(shape) != 2 or self.index >= shape[self.axis]:
            remedy = f"{self.array} has the shape {shape}, and rows and columns count from 0"
            raise InputError("no such row or column", remedy=remedy, channel=self.key)
        check_numbers(dtype, (shape[1 - self.axis],), self.key)

    def of(self, array: Any) -> npt.NDArray[Any]:
        """The column; nothing else of an array on disk is read."""
        if self.axis is None:
            return np.asarray(array[()])
        return np.array(array[self.index, :] if self.axis == 0 else array[:, self.index])


def parts_of(keys: Iterable[str | int], arrays: Collection[str]) -> list[RequestedColumn]:
    """The requested columns, in the order of the arrays.

    Args:
        keys: names of arrays, or ``name[:,k]`` and ``name[k,:]``.
        arrays: names of those in the file.

    Raises:
        InputError: there is no such array.
    """
    parts = [_part(key, arrays) for key in sorted(keys, key=str)]
    order = {name: place for place, name in enumerate(arrays)}
    return sorted(parts, key=lambda part: (order[part.array], part.axis or 0, part.index))


def _part(key: str | int, arrays: Collection[str]) -> RequestedColumn:
    """An array as a whole, or one row or column of it: q, q[0,:] or q[:,0]."""
    name = str(key)
    if isinstance(key, str) and name in arrays:
        return RequestedColumn(name, name)
    match = _PART.fullmatch(name)
    if isinstance(key, int) or match is None or match["array"] not in arrays:
        raise InputError("no such column", remedy=did_you_mean(match["array"] if match else name, arrays), channel=name)
    if (match["row"] == ":") == (match["column"] == ":"):
        remedy = "take a column as q[:,0] or a row as q[0,:]"
        raise InputError("neither a row nor a column", remedy=remedy, channel=name)
    axis = 1 if match["row"] == ":" else 0
    return RequestedColumn(name, match["array"], axis, int(match["column"] if axis else match["row"]))
