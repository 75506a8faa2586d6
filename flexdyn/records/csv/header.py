"""The head of a CSV file: where names and samples stand, what separates the cells, which columns are wanted."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from flexdyn.errors import InputError, did_you_mean
from flexdyn.records.csv.rows import Block, Dialect, Header
from flexdyn.records.request import Layout, Request
from flexdyn.records.table import check_name, check_time_named

_DELIMITERS = (",", ";", "\t")


@dataclass(frozen=True)
class _Start:
    """The line of names (from 1; 0 if there is none) and its text, and the block that begins with the samples."""

    at: int
    text: str
    samples: Block


def header_of(blocks: Iterator[Block], request: Request) -> tuple[Header, Block]:
    """The header, and what follows it in its block.

    Raises:
        InputError: no header, names that no channel can have, or a column wanted that is not there.
    """
    layout = request.layout
    start = _found(blocks, layout) if layout.names_line is None and layout.first_line is None else _told(blocks, layout)
    number, lines = start.samples
    try:
        asked = request.columns
        header = _every(start, request) if asked is None else _as_asked(start, layout, asked)
    except InputError as error:
        row = error.data.get("row", start.at or number)
        raise InputError(f"line {row}: {error.problem}", **{**error.data, "row": row}) from None
    return header, (number, lines)


def _found(blocks: Iterator[Block], layout: Layout) -> _Start:
    """Names in the first line that is no comment; if that is numbers, in the comment above (numpy.savetxt)."""
    comment = (0, "")
    for number, lines in blocks:
        for offset, line in enumerate(lines):
            at = number + offset
            if line.lstrip().startswith("#"):
                comment = (at, _uncommented(line))
            elif line.strip():
                dialect = Dialect(layout.delimiter or _delimiter(line, layout), layout.decimal)
                if dialect.parse([line], dialect.width(line)) is None:
                    return _Start(at, line, (at + 1, lines[offset + 1 :]))
                return _Start(*comment, (at, lines[offset:]))
    raise InputError("the file is empty", remedy="begin with a header t,q.<joint>,...")


def _told(blocks: Iterator[Block], layout: Layout) -> _Start:
    """Names and samples in the lines that the layout says; without a line of names, in the one above the samples."""
    first = layout.first_line or (layout.names_line or 0) + 1
    at = layout.names_line or first - 1
    if at >= first:
        remedy = "samples follow their names"
        raise InputError(
            "the first line of samples is not below the names", key="first_line", value=first, remedy=remedy
        )
    text = ""
    for number, lines in blocks:
        if 0 <= at - number < len(lines):
            text = _uncommented(lines[at - number])
        if first - number < len(lines):
            return _Start(at, text, (first, lines[first - number :]))
    raise InputError(f"the file ends before line {first}", remedy="give the lines that names and samples stand on")


def _every(start: _Start, request: Request) -> Header:
    """Every column, a channel where no map follows; a first one without a name holds row labels (pandas)."""
    layout = request.layout
    if not start.at:
        raise InputError("no header", remedy="begin with a header t,q.<joint>,...")
    dialect = Dialect(layout.delimiter or _delimiter(start.text, layout), layout.decimal)
    names = tuple(dialect.split(start.text))
    wanted: dict[str, int] = {}
    for column, name in enumerate(names):
        if name == "" and column == 0 and len(names) > 1:
            continue
        if name != "t" and not request.mapped:
            check_name(name)
        if name in wanted:
            raise InputError("the channel is there twice", key=name, remedy="rename or remove one", channel=name)
        wanted[name] = column
    if not request.mapped:
        check_time_named(wanted)
    return Header(dialect, len(names), names, wanted, start.samples[0])


def _as_asked(start: _Start, layout: Layout, asked: frozenset[str | int]) -> Header:
    """The columns asked for; the first row tells how many there are, whatever stands above it."""
    number, lines = start.samples
    row = lines[0] if lines else start.text
    dialect = Dialect(layout.delimiter or _delimiter(row, layout, start.text), layout.decimal)
    width = len(dialect.split(row))
    names = tuple(dialect.split(start.text)) if start.at else ()
    wanted = {_key(one): _column(one, names, width) for one in sorted(asked, key=str)}
    return Header(dialect, width, names, wanted, number)


def _key(asked: str | int) -> str:
    return asked if isinstance(asked, str) else f"column {asked}"


def _column(asked: str | int, names: tuple[str, ...], width: int) -> int:
    """Index of a column asked for by name, or by number from 1."""
    if isinstance(asked, int):
        if not 1 <= asked <= width:
            raise InputError("no such column", key=_key(asked), remedy=f"there are {width}", channel=_key(asked))
        return asked - 1
    places = [column for column, name in enumerate(names[:width]) if name == asked]
    if not places:
        raise InputError("no such column", key=asked, remedy=did_you_mean(asked, filter(None, names)), channel=asked)
    if len(places) > 1:
        numbers = " and ".join(str(place + 1) for place in places)
        remedy = f"give the number of one: {numbers}"
        raise InputError("several columns have the name", key=asked, remedy=remedy, channel=asked)
    return places[0]


def _delimiter(line: str, layout: Layout, names: str = "") -> str:
    """The separator that sets a column t apart; without one, that which `names` has as often, or the commonest.

    White space separates where there is none of the others.
    """
    known = [delimiter for delimiter in _DELIMITERS if delimiter != layout.decimal]
    for delimiter in (*known, " "):
        if "t" in (cell.strip(' "') for cell in line.split(delimiter)):
            return delimiter
    best = max(known, key=lambda one: (names.count(one) == line.count(one) > 0, line.count(one)))
    return best if best in line else " " if " " in line.strip() else ","


def _uncommented(line: str) -> str:
    return line.strip().lstrip("#") if line.lstrip().startswith("#") else line
