"""Columns from the variables of a MATLAB workspace.

A column is named as in MATLAB: a dot selects a field of a struct, brackets select a row or column of a two-dimensional
array, counted from 1: ``t``, ``q.elbow``, ``rec.act_pos(1,:)``, ``ref.phi(:,3)``.
"""

from __future__ import annotations

import json
import re
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from flexdyn.errors import InputError, did_you_mean, listed
from flexdyn.records.array_columns import RequestedColumn
from flexdyn.records.meta import from_json
from flexdyn.records.request import Request
from flexdyn.records.suggestion import columns_of_arrays, suggested_map
from flexdyn.records.table import Rows, Table, as_floats, check_name

KEY = "flexdyn"
"""Text variable with the place of each channel, in order, and the meta data."""

MOST_STRUCTS = 16
"""Structs that may nest in each other."""

MOST_SHOWN = 12
"""Largest number of variables that an error lists."""

_COLUMN = re.compile(r"(?P<path>[^()]+?)\s*(?:\(\s*(?P<row>:|[0-9]{1,9})\s*,\s*(?P<column>:|[0-9]{1,9})\s*\))?")


@dataclass(frozen=True)
class Leaf:
    """A variable, or a field of a struct, that is no struct itself.

    Attributes:
        name: as in MATLAB.
        kind: ``numbers``, ``text``, or another kind in words.
        shape: as in MATLAB.
        values: function that reads it: an array of that shape, or a string.
    """

    name: str
    kind: str
    shape: tuple[int, ...]
    values: Callable[[], Any]

    def __str__(self) -> str:
        """Name and shape as in MATLAB's `whos`, without control characters of the name."""
        name = "".join(letter for letter in self.name[:80] if letter.isprintable())
        return f"{name} ({'x'.join(map(str, self.shape))})" if self.kind == "numbers" else name


class LeafColumns:
    """Takes leaves one by one and keeps the requested ones; without a map, every vector of numbers."""

    def __init__(self, request: Request) -> None:
        self._table = Table(rows=Rows(first=1))
        self._asked = None if request.columns is None else _parts(request.columns)
        self._mapped = request.mapped
        self._seen: list[str] = []
        self._misfit: InputError | None = None
        self._text = ""
        self._shapes: dict[str, tuple[int, ...]] = {}

    def variables(self) -> list[str] | None:
        """Names of the requested variables and of those with a requested field; None: all."""
        return None if self._asked is None else [part.array.split(".")[0] for part in self._asked]

    def wants(self, variable: str) -> bool:
        """Whether a variable is requested or contains a requested one; names of others are remembered."""
        variables = self.variables()
        if variables is None or variable in variables:
            return True
        self._seen.append(variable)
        return False

    def take(self, leaves: Iterable[Leaf]) -> None:
        """Read what is wanted of these."""
        for leaf in leaves:
            self._seen.append(str(leaf))
            if leaf.kind == "numbers" and len(self._shapes) < MOST_SHOWN and leaf.name.isprintable():
                self._shapes[leaf.name] = leaf.shape
            if self._asked is not None:
                self._take_asked(leaf, self._asked)
            elif leaf.name == KEY and leaf.kind == "text":
                self._text = leaf.values()
            elif leaf.kind == "numbers":
                self._take_channel(leaf)

    def table(self) -> Table:
        """The columns, in the order in which they were written if the file tells it.

        Raises:
            InputError: a requested variable does not exist; without a map, a variable is no channel.
        """
        table = self._table
        if self._asked is None:
            if not self._mapped:
                self._check_convention()
            return _as_written(table, self._text) if self._text else table
        for part in self._asked:
            if part.key not in table.columns:
                names = [seen.split(" (")[0] for seen in self._seen]
                raise InputError("no such column", remedy=did_you_mean(part.key, names), channel=part.key)
        return table

    def _check_convention(self) -> None:
        """Refuse what cannot be read without a channel map: no time, an array, or a column of another length."""
        table = self._table
        if "t" not in table.columns:
            suggested = suggested_map(columns_of_arrays(self._shapes))
            told = f"what the columns are (--map), such as {suggested}" if suggested else "where it is"
            there = listed(self._seen, MOST_SHOWN) or "none"
            remedy = f"name the column of time [s] t, or say in a channel map {told}; there are {there}"
            raise InputError("no column t", remedy=remedy, channel="t")
        if self._misfit is not None:
            raise self._misfit
        samples = len(table.columns["t"])
        for name, values in table.columns.items():
            if len(values) != samples:
                problem = f"{len(values)} values where t has {samples}"
                raise InputError(problem, remedy="say in a channel map which columns to read", channel=name)

    def _take_channel(self, leaf: Leaf) -> None:
        """Take a variable as a channel."""
        if leaf.name != "t" and not self._mapped:
            check_name(leaf.name)
        if max(leaf.shape, default=0) != np.prod(leaf.shape, dtype=object):
            remedy = f"a channel map takes its rows or columns, such as {leaf.name}(:,1)"
            self._misfit = self._misfit or InputError(f"an array, not a column: {leaf}", key=leaf.name, remedy=remedy)
            return
        self._add(leaf.name, leaf.values().reshape(-1))

    def _take_asked(self, leaf: Leaf, asked: list[RequestedColumn]) -> None:
        """Take the columns of a variable that are asked for."""
        for part in asked:
            if leaf.kind != "numbers" and f"{part.array}.".startswith(f"{leaf.name}."):
                remedy = "in MATLAB, save plain arrays of doubles"
                raise InputError(f"{leaf.name} is {leaf.kind}, not numbers", remedy=remedy, channel=part.key)
        if wanted := [part for part in asked if part.array == leaf.name]:
            values = leaf.values()
            for part in wanted:
                self._add(part.key, _requested_vector(leaf, values, part))

    def _add(self, key: str, values: npt.NDArray[Any]) -> None:
        # A copy, so that the variable's memory can be released.
        self._table.add(key, as_floats(values, key, copy=True))


def _parts(columns: frozenset[str | int]) -> list[RequestedColumn]:
    """The requested columns: q, q(3,:) or q(:,3)."""
    asked = []
    for key in sorted(columns, key=str):
        match = _COLUMN.fullmatch(key) if isinstance(key, str) else None
        if match is None or (match["row"] and (match["row"] == ":") == (match["column"] == ":")):
            remedy = "write it as MATLAB does: t, q.elbow, q(1,:) or q(:,1)"
            raise InputError("not the name of a column in a MAT file", remedy=remedy, channel=str(key))
        axis = None if not match["row"] else 1 if match["row"] == ":" else 0
        index = 0 if axis is None else int(match["column"] if axis else match["row"]) - 1
        asked.append(RequestedColumn(str(key), match["path"].strip(), axis, index))
    return asked


def _requested_vector(leaf: Leaf, values: npt.NDArray[Any], part: RequestedColumn) -> npt.NDArray[Any]:
    """A vector, or the requested row or column."""
    if part.axis is None:
        if max(leaf.shape, default=0) != values.size:
            remedy = f"take a row or column, such as {leaf.name}(1,:) or {leaf.name}(:,1)"
            raise InputError(f"an array, not a column: {leaf}", remedy=remedy, channel=part.key)
        return values.reshape(-1)
    if values.ndim != 2 or not 0 <= part.index < values.shape[part.axis]:
        remedy = f"it is {leaf}; rows and columns count from 1"
        raise InputError("no such row or column", remedy=remedy, channel=part.key)
    return part.of(values)


def _as_written(table: Table, text: str) -> Table:
    """Channels under their own names and in their order; columns that were added later follow."""
    try:
        content = json.loads(text)
        pairs = {str(place): str(name) for name, place in content["channels"]}
        meta = from_json(json.dumps(content["meta"]))
    except (ValueError, TypeError, KeyError, RecursionError):
        remedy = "leave it as it was written, or delete it"
        raise InputError("not the text that belongs there", key=KEY, value=text, remedy=remedy) from None
    known = Table(meta=meta, rows=table.rows)
    for place in (*pairs, *(name for name in table.columns if name not in pairs)):
        if place not in table.columns:
            remedy = f"copy the file again; if you removed the column, remove {KEY} too"
            raise InputError(f"the column is not there, and {KEY} lists it", remedy=remedy, channel=place)
        known.add(pairs.get(place, place), table.columns[place])
    return known
