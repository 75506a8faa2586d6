"""A channel map suggested for columns that do not follow the convention: a line to be copied and corrected."""

from __future__ import annotations

import re
from collections.abc import Sequence

from flexdyn.records.channelmap.known_units import UNITS, plain_unit
from flexdyn.records.column_names import split_unit

_SIGNALS = {"angle": "q", "length": "q", "angular velocity": "v", "velocity": "v", "torque": "tau", "force": "tau"}
_WORDS = {
    "q": r"pos|angle|winkel|\bist\b|actual|lage",
    "v": r"vel|speed|geschw|drehzahl",
    "tau": r"torq|moment|effort|\btau|force|kraft",
}
_ASKED = re.compile(r"soll|cmd|command|desired|target|ref|setpoint", re.IGNORECASE)
"""Words of columns that were asked for and not measured."""
_PLAIN = re.compile(r"[A-Za-z_À-ÿ][\w À-ÿ./-]*")
MOST = 3
"""Channels in the suggestion."""


def remedy_without_time(names: Sequence[str]) -> str:
    """What to do about a table without a column ``t``."""
    alike = [name for name in names if _is_time(name)]
    rename = f"did you mean '{alike[0]}'? name it t" if alike else "name the column of time [s] t"
    suggested = suggested_map(names)
    if not suggested:
        return rename
    return f"{rename}, or say what the columns are in a channel map (--map), such as {suggested}"


def suggested_map(names: Sequence[str]) -> str:
    """A channel map in one line of YAML, in which JOINT stands for the joint's name; empty where nothing is known."""
    rest = [name for name in names if name and not _is_time(name)]
    found: dict[str, str] = {}
    for name in rest:
        signal = _signal(name)
        if signal and signal not in found and not _ASKED.search(name):
            found[signal] = name
    if not found:
        return ""
    clock = next((name for name in names if _is_time(name)), "")
    time = f"time: {_quoted(clock)}" if clock else "time: {rate: HERTZ}"
    channels = ", ".join(f"{signal}.JOINT: {_quoted(name)}" for signal, name in list(found.items())[:MOST])
    return f"{{flexdyn_map: 1, {time}, channels: {{{channels}}}}}"


def _is_time(name: str) -> bool:
    low = name.lower()
    return low.startswith(("time", "stamp", "sec", "zeit")) or low[:2].strip(" [(") == "t"


def _signal(name: str) -> str:
    bare, unit = split_unit(name)
    if unit and plain_unit(unit) in UNITS:
        return _SIGNALS.get(UNITS[plain_unit(unit)].quantity, "")
    return next((signal for signal, words in _WORDS.items() if re.search(words, bare, re.IGNORECASE)), "")


def _quoted(name: str) -> str:
    """The name without its unit, as YAML takes it inside braces."""
    bare = split_unit(name)[0]
    return bare if _PLAIN.fullmatch(bare) else '"' + bare.replace("\\", "\\\\").replace('"', '\\"') + '"'
