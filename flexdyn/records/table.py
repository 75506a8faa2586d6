"""The raw table of a file, and the checks before it becomes a recording."""

from __future__ import annotations

import sys
from collections.abc import Collection, Container, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import numpy.typing as npt

from flexdyn.arrays import Array, Indices
from flexdyn.errors import FlexdynError, InputError
from flexdyn.records.bounds import MOST_SAMPLES, check_count
from flexdyn.records.suggestion import remedy_without_time

RESERVED = "__meta__"

_LARGEST_INTEGER = 2**53
_LONGEST_NAME = 255


@dataclass(frozen=True)
class Rows:
    """How the rows of a source are counted: arrays from row 0, text files by line.

    Attributes:
        word: name of a row in messages.
        first: number of the first row.
        kept: index of each row in the source, if a repair moved or dropped rows; None: unchanged.
    """

    word: str = "row"
    first: int = 0
    kept: Indices | None = None

    def taken(self, order: Indices) -> Rows:
        """The numbering for a selection of rows, in that order."""
        return Rows(self.word, self.first, order if self.kept is None else self.kept[order])

    def number(self, index: int) -> int:
        """Number of the row in the source, by its index."""
        return self.first + (index if self.kept is None or index >= len(self.kept) else int(self.kept[index]))

    def error(
        self, problem: str, *, index: int, channel: str, value: Any = None, remedy: str | None = None
    ) -> InputError:
        """An error that names row and channel in its line and has both as data."""
        row = self.number(index)
        return InputError(f"{self.word} {row}: {problem}", value=value, remedy=remedy, row=row, channel=channel)


@dataclass
class Table:
    """Columns of a file before they are checked; nothing else uses the arrays.

    Attributes:
        columns: arrays by name.
        meta: as in a recording.
        rows: numbering of rows in errors.
        units: in the file, by column; None for a unit that cannot be read.
        said: guesses and notes of the reader, one sentence each, which are shown to the user.
    """

    columns: dict[str, npt.NDArray[Any]] = field(default_factory=dict)
    meta: dict[str, Any] = field(default_factory=dict)
    rows: Rows = field(default_factory=Rows)
    units: dict[str, str | None] = field(default_factory=dict)
    said: list[str] = field(default_factory=list)

    def add(self, name: str, values: npt.NDArray[Any]) -> None:
        """Append a column; a name that exists already, or a column beyond the limits of a file, is refused.

        Raises:
            InputError: such a column.
        """
        check_new(name, self.columns)
        check_count(len(self.columns) + 1)
        if values.size > MOST_SAMPLES:
            problem = f"the column has {values.size} rows, more than {MOST_SAMPLES}"
            raise InputError(problem, remedy="split the recording", channel=name)
        self.columns[name] = values


def check_new(name: str, names: Container[str]) -> None:
    """Refuse a channel that is there already.

    Raises:
        InputError: `names` holds it.
    """
    if name in names:
        raise InputError("the channel is there twice", remedy="rename or remove one", channel=name)


def check_name(name: str) -> None:
    """Refuse a channel name that some format cannot store.

    Raises:
        InputError: empty, ``t``, with a comma or an unprintable character, longer than 255, or with a space at an end.
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
        remedy = "name channels <signal>.<joint>, such as q.elbow"
        raise InputError(problem, key="", value=name, remedy=remedy, channel=name)


def check_time_named(names: Collection[str], gaps: Collection[str] = ()) -> None:
    """Refuse a table without a column ``t``; the message names the most similar column.

    Args:
        names: of its columns.
        gaps: columns with empty cells.

    Raises:
        InputError: there is no ``t``.
    """
    if "t" in names:
        return
    raise InputError("no column t", remedy=remedy_without_time(list(names), gaps), channel="t")


def as_floats(values: npt.ArrayLike, channel: str, *, copy: bool) -> Array:
    """One column as doubles, read-only.

    Args:
        values: real numbers, one-dimensional.
        channel: name of the column, for errors.
        copy: False if the array was made for this recording and nothing else uses it.

    Returns:
        A read-only contiguous array (samples,).

    Raises:
        InputError: not numbers, not one-dimensional, or integers that a double cannot represent exactly.
    """
    ma = sys.modules.get("numpy.ma")  # not imported: no masked arrays
    if ma is not None and isinstance(values, ma.MaskedArray):
        values = ma.filled(values.astype(np.float64), np.nan)
    try:
        array = np.asarray(values)
    except (TypeError, ValueError):
        array = np.asarray(None)
    check_numbers(array.dtype, array.shape, channel)
    if array.dtype.kind in "iu" and array.size and max(int(array.max()), -int(array.min())) > _LARGEST_INTEGER:
        remedy = "give seconds and SI units as floating point"
        raise InputError("integers beyond 2^53 are no exact doubles", remedy=remedy, channel=channel)
    floats = np.array(array, np.float64) if copy else np.ascontiguousarray(array, np.float64)
    floats.setflags(write=False)
    return floats


def check_numbers(dtype: np.dtype[Any], shape: tuple[int, ...], channel: str) -> None:
    """Refuse a column that is not one-dimensional with real numbers, before it is read.

    Args:
        dtype: of its numbers.
        shape: of the column.
        channel: its name.

    Raises:
        InputError: objects, text, complex or extended numbers, or not one dimension.
    """
    if dtype.kind not in "fiub" or dtype.itemsize > 8:
        kind = "objects" if dtype.hasobject else f"the type {dtype}"
        remedy = "give real numbers"
        raise InputError(f"the column holds {kind}, not doubles", key=channel, remedy=remedy, channel=channel)
    if len(shape) != 1:
        text = f"the column has the shape {shape}"
        raise InputError(text, remedy="give one dimension, one number per sample", channel=channel)


def checked(columns: Mapping[str, npt.ArrayLike], rows: Rows, *, copy: bool) -> tuple[Array, dict[str, Array]]:
    """Check time and channels of a recording.

    Args:
        columns: ``t`` and the channels.
        rows: numbering of rows in errors.
        copy: as in `as_floats`.

    Returns:
        Time (samples,) [s] and the channels, all read-only.

    Raises:
        InputError: a violation of section 4 of the contract; the line names row and channel.
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


def check_lengths(columns: Mapping[str, Array], rows: Rows) -> None:
    """Refuse columns that are shorter or longer than ``t``.

    Raises:
        InputError: the message names the first missing row.
    """
    length = len(columns["t"])
    for name, values in columns.items():
        if len(values) != length:
            problem = f"{len(values)} samples where t has {length}"
            row = rows.number(min(len(values), length))
            raise InputError(problem, remedy="give one number per sample", row=row, channel=name)


def check_finite(values: Array, channel: str, rows: Rows) -> None:
    """Refuse a column with a number that is not finite.

    Args:
        values: of the column.
        channel: its name.
        rows: how the file counts them.

    Raises:
        InputError: the message names the first such row and possible repairs.
    """
    finite = np.isfinite(values)
    if not finite.all():
        index = int(np.argmin(finite))
        value, problem = float(values[index]), "not a finite number"
        remedy = "remove or fill the gap (repair drop_nan or fill_nan); an empty cell counts as nan"
        raise rows.error(problem, index=index, channel=channel, value=value, remedy=remedy)


def check_time(t: Array, rows: Rows) -> None:
    """Refuse times that do not increase strictly.

    Args:
        t: times [s].
        rows: how the file counts them.

    Raises:
        InputError: the message names the row and a possible repair.
    """
    if len(t) < 2:
        raise InputError(f"{len(t)} samples are too few", remedy="give two or more", channel="t")
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
    """Convert any exception of a file library for a damaged file to one line.

    The libraries do not specify their exceptions for hostile bytes, so every kind is caught; keep the block small.

    Args:
        what: in a few words, for the message.

    Raises:
        InputError: the library found damage.
    """
    try:
        yield
    except (FlexdynError, MemoryError):
        raise
    except Exception as error:
        detail = "".join(letter for letter in str(error) if letter.isprintable()) or type(error).__name__
        raise InputError(f"{what} ({detail[:200]})", remedy="the file is damaged or of another format") from error
