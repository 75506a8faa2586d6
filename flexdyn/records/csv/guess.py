"""What a CSV file does not say about itself, guessed from its first megabyte: letters, separator, decimal sign."""

from __future__ import annotations

import codecs
import re
from collections.abc import Sequence
from pathlib import Path

from flexdyn.records.csv.dialect import Dialect
from flexdyn.records.request import Layout

DELIMITERS = (",", ";", "\t")
SAMPLE = 2**20
"""Bytes from which letters are guessed."""
WESTERN = "cp1252"
"""Windows' letters of Western Europe, which contain all of latin-1 that prints."""

_COMMA = re.compile(r"[+-]?\d+,\d+(?:[eE][+-]?\d+)?")
_POINT = re.compile(r"[+-]?\d*\.\d+(?:[eE][+-]?\d+)?")


def encoding_of(path: Path, told: str | None) -> tuple[str, str, str]:
    """How the file's bytes become letters.

    Args:
        path: of the file.
        told: by a channel map.

    Returns:
        Encoding, what becomes of bytes that do not fit it (nothing that is a number), and what was guessed, to be
        said; empty where nothing was.
    """
    if told is not None:
        plain = codecs.lookup(told).name
        return ("utf-8-sig" if plain == "utf-8" else plain), "replace", ""
    with open(path, "rb") as stream:
        sample = stream.read(SAMPLE)
    if sample.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)):
        return "utf-16", "replace", ""
    try:
        codecs.getincrementaldecoder("utf-8")().decode(sample)  # a letter may be cut at the end of the sample
    except UnicodeDecodeError:
        guess = "the text is not UTF-8 and was read as Windows-1252 (latin-1)"
        return WESTERN, "replace", f"{guess}; if names look wrong, say source: {{encoding: ...}} in a channel map"
    return "utf-8-sig", "surrogateescape", ""


def dialect_of(line: str, samples: Sequence[str], layout: Layout, names: str = "") -> Dialect:
    """What separates the cells and the decimals, as the layout says or as it looks.

    Args:
        line: that has every cell.
        samples: lines of numbers, as many as are at hand.
        layout: what is known.
        names: another line that may hold the names.
    """
    delimiter = layout.delimiter or _delimiter(line, layout.decimal, names)
    if layout.decimal is not None or delimiter == ",":
        return Dialect(delimiter, layout.decimal or ".")
    return Dialect(delimiter, "," if _with_commas(Dialect(delimiter), samples) else ".")


def _delimiter(line: str, decimal: str | None, names: str) -> str:
    """The separator that sets a column t apart; without one, that which `names` has as often, or the commonest.

    White space separates where there is none of the others. A comma between two numbers of digits is taken for a
    decimal sign where semicolons or tabs separate such cells.
    """
    known = [delimiter for delimiter in DELIMITERS if delimiter != decimal]
    spaced: tuple[str, ...] = () if any(delimiter in line for delimiter in known) else (" ",)
    for delimiter in (*known, *spaced):
        if {"t", "t [s]"} & {cell.strip(' "') for cell in line.split(delimiter)}:
            return delimiter
    for delimiter in known if decimal is None else ():
        cells = [cell.strip(' "') for cell in line.split(delimiter)]
        alike = not names or names.count(delimiter) == line.count(delimiter)
        if delimiter != "," and len(cells) > 1 and alike and any(map(_COMMA.fullmatch, cells)):
            return delimiter
    best: str = max(known, key=lambda one: (names.count(one) == line.count(one) > 0, line.count(one)))
    return best if best in line else " " if " " in line.strip() else ","


def _with_commas(dialect: Dialect, samples: Sequence[str]) -> bool:
    """Whether some number has a decimal comma and none a point."""
    commas = False
    for line in samples:
        if "," not in line and "." not in line:
            continue
        cells = dialect.split(line)
        if any(map(_POINT.fullmatch, cells)):
            return False
        commas = commas or any(map(_COMMA.fullmatch, cells))
    return commas
