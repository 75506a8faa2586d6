"""The report.json of a diagnosis as untrusted input: what the comparison of models takes from it is checked first."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from flexdyn.checks import as_number
from flexdyn.diagnose.report.document import SCHEMA
from flexdyn.diagnose.report.words import names_number
from flexdyn.errors import InputError
from flexdyn.io.json_file import read_json

MAX_REPORT_BYTES = 20_000_000
"""Largest size of a report.json [bytes]: some hundred times that of an arm with seven joints."""
_REMEDY = "give the folder as flexdyn diagnose wrote it, or the model file alone under another name"


def read_report(path: Path) -> Mapping[str, Any]:
    """Read ``findings``, ``calibration`` and ``considered`` of a report.json.

    Args:
        path: of the file.

    Returns:
        The three lists; each entry has the keys that a comparison needs, with texts and numbers where they belong.

    Raises:
        InputError: no such file, a file that is too large, not JSON, no report of a diagnosis, one of another version
            of the format, or one that was changed so that it cannot be understood.
    """
    content = read_json(path, MAX_REPORT_BYTES)
    schema = content.get("schema") if isinstance(content, dict) else None
    if schema != SCHEMA:
        remedy = f"flexdyn diagnose writes one; this version reads {SCHEMA}"
        raise InputError("it is no report of a diagnosis", file=path, key="schema", value=schema, remedy=remedy)
    for key, value, expected in _misfits(content):
        problem = f"the report of a diagnosis was changed: {expected} is needed"
        raise InputError(problem, file=path, key=key, value=value, remedy=_REMEDY)
    return {key: content[key] for key in ("findings", "calibration", "considered")}


def _misfits(content: Mapping[str, Any]) -> Iterator[tuple[str, Any, str]]:
    """What is not as a diagnosis writes it: its key, its value, and what should be there."""
    for name, check in (("findings", _read_finding), ("calibration", _calibrated), ("considered", _read_considered)):
        entries = content.get(name)
        if not isinstance(entries, list):
            yield name, entries, "a list"
            return
        for place, entry in enumerate(entries):
            key = f"{name}[{place}]"
            if not isinstance(entry, dict):
                yield key, entry, "an object"
            else:
                yield from check(key, entry)


def _read_finding(key: str, entry: Mapping[str, Any]) -> Iterator[tuple[str, Any, str]]:
    yield from _read_considered(key, entry)
    if names_number(str(entry.get("effect"))):
        yield from _texts(key, entry, ("of", "parameter"))
    parameters = entry.get("parameters")
    if not isinstance(parameters, dict):
        yield f"{key}.parameters", parameters, "an object"
        return
    for name, number in parameters.items():
        inside = f"{key}.parameters.{name}"
        if isinstance(number, dict):
            yield from _read_numbers(inside, number, ("value",), ("std",))
        else:
            yield inside, number, "an object"


def _calibrated(key: str, entry: Mapping[str, Any]) -> Iterator[tuple[str, Any, str]]:
    yield from _texts(key, entry, ("of", "parameter"))
    yield from _read_numbers(key, entry, ("factor",), ("std",))


def _read_considered(key: str, entry: Mapping[str, Any]) -> Iterator[tuple[str, Any, str]]:
    """An effect, where it acts, and its probability."""
    yield from _texts(key, entry, ("effect", "channel") if "channel" in entry else ("effect",))
    for name in ("joint", "side"):
        if entry.get(name) is not None:
            yield from _texts(key, entry, (name,))
    yield from _read_numbers(key, entry, (), ("probability",))


def _texts(key: str, entry: Mapping[str, Any], names: tuple[str, ...]) -> Iterator[tuple[str, Any, str]]:
    for name in names:
        if not isinstance(entry.get(name), str):
            yield f"{key}.{name}", entry.get(name), "a text"


def _read_numbers(
    key: str, entry: Mapping[str, Any], any_sign: tuple[str, ...], positive: tuple[str, ...]
) -> Iterator[tuple[str, Any, str]]:
    """Finite numbers, the positive ones of at least 0; null is a number that the diagnosis could not tell."""
    for name in (*any_sign, *positive):
        given = entry.get(name, "")
        number = 0.0 if given is None else as_number(given)
        if not math.isfinite(number) or (name in positive and number < 0.0):
            yield f"{key}.{name}", given, "a number of at least 0" if name in positive else "a number"
