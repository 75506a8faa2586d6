"""Guess from the first megabyte of a CSV file: encoding, separator, decimal sign."""

from __future__ import annotations

import codecs
import re
from collections.abc import Sequence
from pathlib import Path

from flexdyn.records.csv.dialect import Dialect
from flexdyn.records.request import Layout

DELIMITERS = (",", ";", "\t")
SAMPLE = 2**20
"""Number of bytes from which the encoding is guessed."""
WESTERN = "cp1252"
"""Windows' encoding of Western Europe, which contains all printable characters of latin-1."""

_COMMA = re.compile(r"[+-]?\d+,\d+(?:[eE][+-]?\d+)?")
_DECIMAL_POINT = re.compile(r"[+-]?\d*\.\d+(?:[eE][+-]?\d+)?")


def encoding_of(path: Path, told: str | None) -> tuple[str, str, str]:
    """The encoding of a file.

    Args:
        path: of the file.
        told: encoding in the channel map, if any.

    Returns:
        The encoding, the treatment of bytes that do not fit it (they are never part of a number), and a note about the
        guess; empty if nothing was guessed.
    """
    if told is not None:
        plain = codecs.lookup(told).name
        return ("utf-8-sig" if plain == "utf-8" else plain), "replace", ""
    with open(path, "rb") as stream:
        sample = stream.read(SAMPLE)
    if sample.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)):
        return "utf-16", "replace", ""
    try:
        codecs.getincrementaldecoder("utf-8")().decode(sample)  # the sample may end within a letter
    except UnicodeDecodeError:
        guess = "the text is not UTF-8 and was read as Windows-1252 (latin-1)"
        return WESTERN, "replace", f"{guess}; if names look wrong, say source: {{encoding: ...}} in a channel map"
    return "utf-8-sig", "surrogateescape", ""


def dialect_of(line: str, samples: Sequence[str], layout: Layout, names: str = "") -> Dialect:
    """The separator of cells and the decimal sign, from the layout or guessed.

    Args:
        line: that has every cell.
        samples: some lines of numbers.
        layout: known properties.
        names: another line that may contain the names.
    """
    delimiter = layout.delimiter or _delimiter(line, layout.decimal, names)
    if layout.decimal is not None or delimiter == ",":
        return Dialect(delimiter, layout.decimal or ".")
    return Dialect(delimiter, "," if _with_commas(Dialect(delimiter), samples) else ".")


def _delimiter(line: str, decimal: str | None, names: str) -> str:
    """The separator that gives a column t; else the one that occurs as often in `names`; else the most frequent one.

    White space is the separator if there is no other. A comma between two groups of digits is taken as a decimal sign
    if semicolons or tabs separate such cells.
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
        if any(map(_DECIMAL_POINT.fullmatch, cells)):
            return False
        commas = commas or any(map(_COMMA.fullmatch, cells))
    return commas
