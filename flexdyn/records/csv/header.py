"""The head of a CSV file: the lines of names and samples, the separator, the requested columns."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass, replace

from flexdyn.errors import InputError, did_you_mean
from flexdyn.records.bounds import check_count
from flexdyn.records.channelmap.description import column_name
from flexdyn.records.channelmap.known_units import split_unit
from flexdyn.records.csv.dialect import NOTHING, Dialect, Stamps, is_stamp
from flexdyn.records.csv.guess import dialect_of
from flexdyn.records.csv.rows import Block, Header
from flexdyn.records.request import Layout, Request
from flexdyn.records.table import check_name, check_new, check_time_named
from flexdyn.records.units import split_name


@dataclass(frozen=True)
class _Start:
    """The line of names (from 1; 0 if there is none) and its text, and the block that begins with the samples."""

    at: int
    text: str
    samples: Block


def header_of(blocks: Iterator[Block], request: Request) -> tuple[Header, Block]:
    """The header, and what follows it in its block.

    Args:
        blocks: of lines, from the first one on.
        request: what is wanted, and how the file is laid out.

    Raises:
        InputError: no header, names that no channel can have, or a requested column that does not exist.
    """
    layout = request.layout
    start = _found(blocks, layout) if layout.names_line is None and layout.first_line is None else _told(blocks, layout)
    asked = request.columns
    try:
        header = _every(start, request) if asked is None else _as_asked(start, layout, asked)
    except InputError as error:
        row = error.data.get("row", start.at or start.samples[0])
        raise InputError(f"line {row}: {error.problem}", **{**error.data, "row": row}) from None
    return header, start.samples


def _found(blocks: Iterator[Block], layout: Layout) -> _Start:
    """Names in the first line that is no comment; if that line has numbers, in the comment above (numpy.savetxt)."""
    comment = (0, "")
    for number, lines in blocks:
        for offset, line in enumerate(lines):
            at = number + offset
            if line.lstrip().startswith("#"):
                comment = (at, _uncommented(line))
            elif line.strip():
                dialect = dialect_of(line, [line], layout)
                if dialect.blank(line):
                    continue
                if dialect.parse([line], dialect.width(line)) is None:
                    return _Start(at, line, (at + 1, lines[offset + 1 :]))
                return _Start(*comment, (at, lines[offset:]))
    raise InputError("the file is empty", remedy="begin with a header t,q.<joint>,...")


def _told(blocks: Iterator[Block], layout: Layout) -> _Start:
    """Names and samples in the lines that the layout gives; without a line of names, the line above the samples."""
    first = layout.first_line or (layout.names_line or 0) + 1
    at = layout.names_line or first - 1
    if at >= first:
        problem, remedy = "the first line of samples is not below the names", "the samples must come after their names"
        raise InputError(problem, key="first_line", value=first, remedy=remedy)
    text = ""
    for number, lines in blocks:
        if 0 <= at - number < len(lines):
            text = _uncommented(lines[at - number])
        if first - number < len(lines):
            return _Start(at, text, (first, lines[first - number :]))
    raise InputError(f"the file ends before line {first}", remedy="give the lines of names and samples")


def _every(start: _Start, request: Request) -> Header:
    """Every column; without a map each is a channel."""
    if not start.at:
        raise InputError("no header", remedy="begin with a header t,q.<joint>,...")
    dialect = dialect_of(start.text, start.samples[1], request.layout)
    names = tuple(dialect.split(start.text))
    first = _first_sample(dialect, start)
    wanted: dict[str, int] = {}
    units: dict[str, str] = {}
    for column, name in enumerate(names):
        if name == "" and len(names) > 1 and (column == 0 or (column == len(names) - 1 and first[column:] == [""])):
            continue  # labels of rows (pandas), or an empty cell after a separator at the end of the line
        key, unit = _column_channel(name, request)
        if key != "t" and not request.mapped:
            check_name(key)
        check_new(key, wanted)
        wanted[key] = column
        if unit:
            units[key] = unit
    if names[0] == "" and "t" not in wanted and first and is_stamp(first[0]):
        wanted = {"t": 0, **wanted}  # pandas with an index of times
    if not request.mapped and "t" not in wanted:
        check_time_named(names, _with_gaps(dialect, names, start.samples[1]))
    told = request.layout.decimal is not None
    return _with_stamps(Header(dialect, len(names), names, wanted, start.samples[0], units, told), start)


def _with_gaps(dialect: Dialect, names: tuple[str, ...], lines: list[str]) -> set[str]:
    """Columns with empty cells in these lines."""
    rows = (dialect.split(line) for line in lines)
    return {name for row in rows for name, cell in zip(names, row, strict=False) if re.fullmatch(NOTHING, cell)}


def _column_channel(name: str, request: Request) -> tuple[str, str]:
    """Key of a column in the table, and the unit in its name."""
    bare, unit = split_unit(name)
    if request.mapped:
        return (bare if bare in request.named and name not in request.named else name), unit
    return (bare if unit and (bare == "t" or split_name(bare)) else name), unit


def _as_asked(start: _Start, layout: Layout, asked: frozenset[str | int]) -> Header:
    """The requested columns; the first row determines their number."""
    _, lines = start.samples
    row = lines[0] if lines else start.text
    dialect = dialect_of(row, lines, layout, start.text)
    width = len(dialect.split(row))
    names = tuple(dialect.split(start.text)) if start.at else ()
    wanted = {column_name(one): _column_index(one, names, width) for one in sorted(asked, key=str)}
    stated = {key: split_unit(names[column])[1] for key, column in wanted.items() if column < len(names)}
    units = {key: unit for key, unit in stated.items() if unit}
    told = layout.decimal is not None
    return _with_stamps(Header(dialect, width, names, wanted, start.samples[0], units, told), start)


def _with_stamps(header: Header, start: _Start) -> Header:
    """The header with a reader of stamps for the first requested column with dates."""
    check_count(header.width)
    first = _first_sample(header.dialect, start)
    dated = [column for column in header.wanted.values() if column < len(first) and is_stamp(first[column])]
    return replace(header, dialect=replace(header.dialect, stamps=Stamps(dated[0]))) if dated else header


def _first_sample(dialect: Dialect, start: _Start) -> list[str]:
    """Cells of the first row that is not empty."""
    line = next((line for line in start.samples[1] if line.strip()), "")
    return dialect.split(line) if line else []


def _column_index(asked: str | int, names: tuple[str, ...], width: int) -> int:
    """Index of a column that was requested by name, or by number from 1."""
    if isinstance(asked, int):
        if not 1 <= asked <= width:
            raise InputError("no such column", remedy=f"there are {width}", channel=column_name(asked))
        return asked - 1
    places = [column for column, name in enumerate(names[:width]) if name == asked]
    places = places or [column for column, name in enumerate(names[:width]) if split_unit(name)[0] == asked]
    if not places:
        raise InputError("no such column", remedy=did_you_mean(asked, filter(None, names)), channel=asked)
    if len(places) > 1:
        numbers = " and ".join(str(place + 1) for place in places)
        raise InputError("several columns have the name", remedy=f"give the number of one: {numbers}", channel=asked)
    return places[0]


def _uncommented(line: str) -> str:
    return line.strip().lstrip("#") if line.lstrip().startswith("#") else line
