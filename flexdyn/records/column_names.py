"""Names of columns that state a unit: ``Ist [°]``, ``speed (rpm)``."""

from __future__ import annotations

import re

from flexdyn.records.channelmap.known_units import UNITS, plain_unit
from flexdyn.records.units import UNITLESS

_WITH_UNIT = re.compile(r"(?P<bare>.*?\S)(?P<gap>\s*)(?:\[(?P<square>[^\[\]]*)\]|\((?P<round>[^()]*)\))")


def split_unit(name: str) -> tuple[str, str]:
    """Name and unit of a column's name; the unit is empty if the name has none.

    A text in brackets at the end is a unit if it is a known one. After a space, a text in square brackets is always a
    unit, unless it is a number, which is an index.
    """
    match = _WITH_UNIT.fullmatch(name)
    if match is None:
        return name, ""
    text = (match["square"] if match["square"] is not None else match["round"]).strip()
    known = plain_unit(text) in UNITS
    stated = match["square"] is not None and match["gap"] and text and not text.isdigit()
    unitless = text in UNITLESS and match["square"] is not None and match["gap"]
    return (match["bare"], text) if known or stated or unitless else (name, "")
