"""The raw table that a file holds, and the checks that stand between it and a recording."""

from __future__ import annotations

import sys
from collections.abc import Collection, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import numpy.typing as npt

from flexdyn.errors import FlexdynError, InputError
from flexdyn.records.bounds import MOST_SAMPLES, check_count
from flexdyn.records.suggestion import remedy_without_time

FloatArray = npt.NDArray[np.float64]

RESERVED = "__meta__"

_LARGEST_INTEGER = 2**53
_LONGEST_NAME = 255


@dataclass(frozen=True)
class Rows:
    """How the rows of a source are counted: arrays from row 0, text files by the line each row stands on.

    Attributes:
        word: what a row is called.
        first: number of the first.
        kept: index that each row had in the source, where a repair moved or dropped some; None: as they are.
    """

    word: str = "row"
    first: int = 0
    kept: npt.NDArray[np.intp] | None = None

    def taken(self, order: npt.NDArray[np.intp]) -> Rows:
        """How to count those rows, in that order."""
        return Rows(self.word, self.first, order if self.kept is None else self.kept[order])

    def number(self, index: int) -> int:
        """Number in the source of the row at an index."""
        return self.first + (index if self.kept is None or index >= len(self.kept) else int(self.kept[index]))

    def error(
        self, problem: str, *, index: int, channel: str, value: Any = None, remedy: str | None = None
    ) -> InputError:
        """An error that names row and channel in its line and carries both as data."""
        row = self.number(index)
        text = f"{self.word} {row}: {problem}"
        return InputError(text, key=channel, value=value, remedy=remedy, row=row, channel=channel)


@dataclass
class Table:
    """Columns as a file has them, before they are checked; the arrays belong to the table alone.

    Attributes:
        columns: arrays by name.
        meta: as a recording's.
        rows: how to count rows in errors.
        units: that the file states, by column; None where it states one in a way that is not read.
        said: what was guessed or noticed while reading, one sentence each; the user is told.
    """

    columns: dict[str, npt.NDArray[Any]] = field(default_factory=dict)
    meta: dict[str, Any] = field(default_factory=dict)
    rows: Rows = field(default_factory=Rows)
    units: dict[str, str | None] = field(default_factory=dict)
    said: list[str] = field(default_factory=list)

    def add(self, name: str, values: npt.NDArray[Any]) -> None:
        """Append a column; one of a name that is already there, or beyond the bounds of a file, is refused."""
        if name in self.columns:
            raise InputError("the channel is there twice", key=name, remedy="rename or remove one", channel=name)
        check_count(len(self.columns) + 1)
        if values.size > MOST_SAMPLES:
            problem = f"the column has {values.size} rows, more than {MOST_SAMPLES}"
            raise InputError(problem, key=name, remedy="split the recording", channel=name)
        self.columns[name] = values


def check_name(name: str) -> None:
    """Refuse a channel name that some format could not carry.

    Raises:
        InputError: empty, ``t``, with a comma or a character that does not print, longer than 255, or framed by spaces.
    """
    problem = ""
    if not isinstance(name, str) or not name:
        problem = "the channel has no name"
    elif name in ("t", RESERVED):
        problem = "the name is reserved"
    elif not name.isprintable() or "," in name:
        problem = "the channel's name holds a comma or a character that does not print"
    elif len(name) > _LONGEST_NAME:
        problem = f"the channel's name is longer than {_LONGEST_NAME} characters"
    elif name != name.strip():
        problem = "the channel's name begins or ends with a space"
    elif name.endswith(".") and name.count(".") == 1:
        problem = "no joint follows the dot"
    if problem:
        raise InputError(problem, value=name, remedy="name channels <signal>.<joint>, such as q.elbow", channel=name)


def check_time_named(names: Collection[str], gaps: Collection[str] = ()) -> None:
    """Refuse a table without a column ``t``, naming the column that looks like it.

    Args:
        names: of its columns.
        gaps: columns in which cells are empty.

    Raises:
        InputError: there is no ``t``.
    """
    if "t" in names:
        return
    raise InputError("no column t", key="t", remedy=remedy_without_time(list(names), gaps), channel="t")


def as_floats(values: npt.ArrayLike, channel: str, *, copy: bool) -> FloatArray:
    """One column as doubles, locked.

    Args:
        values: real numbers, one-dimensional.
        channel: name of the column, for errors.
        copy: False if the array was made for this recording and nobody else holds it.

    Returns:
        A read-only contiguous array (samples,).

    Raises:
        InputError: not numbers, not one-dimensional, or integers that no double can hold exactly.
    """
    ma = sys.modules.get("numpy.ma")  # nobody has a masked array who has not imported it, which takes a while
    if ma is not None and isinstance(values, ma.MaskedArray):
        values = ma.filled(values.astype(np.float64), np.nan)
    try:
        array = np.asarray(values)
    except (TypeError, ValueError):
        array = np.asarray(None)
    check_numbers(array.dtype, array.shape, channel)
    if array.dtype.kind in "iu" and array.size and max(int(array.max()), -int(array.min())) > _LARGEST_INTEGER:
        remedy = "give seconds and SI units as floating point"
        raise InputError("integers beyond 2^53 are no exact doubles", key=channel, remedy=remedy, channel=channel)
    floats = np.array(array, np.float64) if copy else np.ascontiguousarray(array, np.float64)
    floats.setflags(write=False)
    return floats


def check_numbers(dtype: np.dtype[Any], shape: tuple[int, ...], channel: str) -> None:
    """Refuse what is not one column of real numbers, before any of it is read.

    Raises:
        InputError: objects, text, complex or extended numbers, or not one dimension.
    """
    if dtype.kind not in "fiub" or dtype.itemsize > 8:
        kind = "objects" if dtype.hasobject else f"the type {dtype}"
        raise InputError(
            f"the column holds {kind}, not doubles", key=channel, remedy="give real numbers", channel=channel
        )
    if len(shape) != 1:
        text = f"the column has the shape {shape}"
        raise InputError(text, key=channel, remedy="give one dimension, one number per sample", channel=channel)


def checked(
    columns: Mapping[str, npt.ArrayLike], rows: Rows, *, copy: bool
) -> tuple[FloatArray, dict[str, FloatArray]]:
    """Time and channels as a recording may hold them.

    Args:
        columns: ``t`` and the channels.
        rows: how to count rows in errors.
        copy: as in `as_floats`.

    Returns:
        Time (samples,) [s] and the channels, all read-only.

    Raises:
        InputError: section 4 of the contract is broken somewhere: the line names row and channel.
    """
    for name in columns:
        if name != "t":
            check_name(name)
    check_time_named(columns)
    t = as_floats(columns["t"], "t", copy=copy)
    check_time(t, rows)
    channels = {name: as_floats(values, name, copy=copy) for name, values in columns.items() if name != "t"}
    if not channels:
        raise InputError("no channel beside t", remedy="add columns <signal>.<joint>, such as q.elbow")
    check_lengths({"t": t, **channels}, rows)
    for name, values in channels.items():
        check_finite(values, name, rows)
    return t, channels


def check_lengths(columns: Mapping[str, FloatArray], rows: Rows) -> None:
    """Refuse columns that are shorter or longer than ``t``.

    Raises:
        InputError: with the first row that one of the two lacks.
    """
    length = len(columns["t"])
    for name, values in columns.items():
        if len(values) != length:
            problem = f"{len(values)} samples where t has {length}"
            row = rows.number(min(len(values), length))
            raise InputError(problem, key=name, remedy="give one number per sample", row=row, channel=name)


def check_finite(values: FloatArray, channel: str, rows: Rows) -> None:
    """Refuse a column that is not a finite number somewhere.

    Raises:
        InputError: naming the first such row and the repairs that would do.
    """
    finite = np.isfinite(values)
    if not finite.all():
        index = int(np.argmin(finite))
        raise rows.error(
            "not a finite number",
            index=index,
            channel=channel,
            value=float(values[index]),
            remedy="remove or fill the gap (repair drop_nan or fill_nan); an empty cell counts as nan",
        )


def check_time(t: FloatArray, rows: Rows) -> None:
    """Refuse times that do not increase strictly.

    Raises:
        InputError: naming the row and the repair that would do.
    """
    if len(t) < 2:
        raise InputError(f"{len(t)} samples are too few", key="t", remedy="give two or more", channel="t")
    check_finite(t, "t", rows)
    grows = t[1:] > t[:-1]
    if not grows.all():
        index = int(np.argmin(grows)) + 1
        same = t[index] == t[index - 1]
        problem = "two samples at one time" if same else f"time runs backwards, from {float(t[index - 1])!r} s"
        repair = "drop_duplicate_times" if same else "sort_time or drop_backwards"
        remedy = f"t must increase strictly (repair {repair})"
        raise rows.error(problem, index=index, channel="t", value=float(t[index]), remedy=remedy)


@contextmanager
def damage_named(what: str) -> Iterator[None]:
    """Turn whatever a file library raises on a damaged file into one line.

    The libraries below promise no kind of exception for hostile bytes, so every kind is taken; keep the block small.
    """
    try:
        yield
    except (FlexdynError, MemoryError):
        raise
    except Exception as error:
        detail = "".join(letter for letter in str(error) if letter.isprintable()) or type(error).__name__
        raise InputError(f"{what} ({detail[:200]})", remedy="the file is damaged or of another format") from error
