"""What the names of columns that do not follow the convention may mean: a channel map to be copied, or other names."""

from __future__ import annotations

import re
from collections.abc import Collection, Iterable, Mapping, Sequence

from flexdyn.records.channelmap.known_units import UNITS, plain_unit, split_unit
from flexdyn.records.units import SIGNALS, split_name

_SIGNAL_OF_QUANTITY = {
    "angle": "q",
    "length": "q",
    "angular velocity": "v",
    "velocity": "v",
    "torque": "tau",
    "force": "tau",
}
_WORDS = {
    "q": r"pos|angle|winkel|\bist\b|actual|lage",
    "v": r"vel|speed|geschw|drehzahl",
    "tau": r"torq|trq|moment|effort|\btau|force|kraft",
}
_ASKED = re.compile(r"soll|cmd|command|desired|target|ref|setpoint", re.IGNORECASE)
"""Words in the names of columns that are commanded and not measured."""
_PLAIN = re.compile(r"[A-Za-z_À-ÿ][\w À-ÿ./-]*")
MOST_CHANNELS = 14
"""Largest number of channels in the suggestion: position and torque of seven joints."""
MOST_JOINTS_SUGGESTED = 7
"""Largest number of columns of a matrix that are taken as one joint each."""


def remedy_without_time(names: Sequence[str], gaps: Collection[str] = ()) -> str:
    """The remedy for a table without a column ``t``.

    Args:
        names: of its columns.
        gaps: columns with empty cells.
    """
    alike = [name for name in names if _is_time(name)]
    rename = f"did you mean '{alike[0]}'? name it t" if alike else "name the column of time [s] t"
    suggested = suggested_map(names, gaps)
    if not suggested:
        return rename
    return f"{rename}, or say what the columns are in a channel map (--map), such as {suggested}"


def suggested_map(names: Sequence[str], gaps: Collection[str] = ()) -> str:
    """A channel map in one line of YAML, with JOINT as a placeholder for the joint's name; empty if nothing is known.

    Args:
        names: of the columns.
        gaps: columns with empty cells, which the map repairs.
    """
    rest = [name for name in names if name and not _is_time(name)]
    found: dict[str, list[str]] = {}
    for name in rest:
        signal = _signal(name)
        if signal and not _ASKED.search(name):
            found.setdefault(signal, []).append(name)
    if not found:
        return ""
    clock = next((name for name in names if _is_time(name)), "")
    time = f"time: {_quoted(clock)}" if clock else "time: {rate: HERTZ}"
    entries = [
        (f"{signal}.JOINT{k + 1 if len(columns) > 1 else ''}", name)
        for signal, columns in found.items()
        for k, name in enumerate(columns)
    ][:MOST_CHANNELS]
    channels = ", ".join(f"{channel}: {_quoted(name)}" for channel, name in entries)
    repair = ", repair: [fill_nan]" if any(name in gaps for _, name in entries) else ""
    return f"{{flexdyn_map: 1, {time}, channels: {{{channels}}}{repair}}}"


def columns_of_arrays(shapes: Mapping[str, tuple[int, ...]]) -> list[str]:
    """Columns of arrays, named as in MATLAB: ``rec.t`` is a vector, ``rec.pos(:,1)`` part of a matrix.

    The longest side of the first vector, else of the first array, is the number of samples.

    Args:
        shapes: of the arrays by name.
    """
    vectors = [shape for shape in shapes.values() if sum(side > 1 for side in shape) == 1]
    samples = max((vectors or list(shapes.values()) or [()])[0], default=0)
    found = []
    for name, shape in shapes.items():
        if len(shape) != 2 or samples not in shape or samples < 2:
            continue
        count = min(shape)
        if count == 1:
            found.append(name)
        elif count <= MOST_JOINTS_SUGGESTED:
            place = "(:,{})" if shape[0] == samples else "({},:)"
            found += [name + place.format(k + 1) for k in range(count)]
    return found


def _is_time(name: str) -> bool:
    if split_name(name):
        return False  # a joint may have the name second
    low = name.rpartition(".")[2].lower()
    return low.startswith(("time", "stamp", "sec", "zeit")) or low[:2].strip(" [(") == "t"


def _signal(name: str) -> str:
    """The signal that a column is likely to be, by its unit or else by words in its name; empty if neither tells."""
    bare, unit = split_unit(name)
    if unit and plain_unit(unit) in UNITS:
        return _SIGNAL_OF_QUANTITY.get(UNITS[plain_unit(unit)].quantity, "")
    # The name of a field says more than the name of its struct: force_test.pos is a position.
    for text in (bare.rpartition(".")[2], bare):
        for signal, words in _WORDS.items():
            if re.search(words, text, re.IGNORECASE):
                return signal
    return ""


def _quoted(name: str) -> str:
    """The name without its unit, in a form for YAML inside braces."""
    bare = split_unit(name)[0]
    return bare if _PLAIN.fullmatch(bare) else '"' + bare.replace("\\", "\\\\").replace('"', '\\"') + '"'


_ANY_SIGNAL = "|".join(sorted(SIGNALS, key=len, reverse=True))
_NEARLY = re.compile(rf"({_ANY_SIGNAL})[_\-/: ](\S.*)", re.IGNORECASE)
MOST_NEAR_NAMES = 3


def nearly_signals(channels: Iterable[str]) -> dict[str, str]:
    """Probable correct names of channels, by their present names; empty if one channel has a correct name."""
    channels = list(channels)
    found: dict[str, str] = {}
    if any(map(split_name, channels)):
        return found
    for name in channels:
        match = None if name in SIGNALS else _NEARLY.fullmatch(name)
        if match is not None:
            found[name] = f"{match[1].lower()}.{match[2]}"
    return found


def asked_back(channels: Iterable[str], signal: str = "") -> str:
    """The question "did you mean ...?" for such channels, as a remedy; empty if there are none.

    Args:
        channels: of a recording.
        signal: that is missing; empty: any.
    """
    meant = nearly_signals(channels)
    near = [(name, other) for name, other in meant.items() if not signal or other.startswith(f"{signal}.")]
    if not near:
        return ""
    listed = ", ".join(f"{other} for {name}" for name, other in near[:MOST_NEAR_NAMES])
    return f"did you mean {listed}{', ...' if len(near) > MOST_NEAR_NAMES else ''}?"
