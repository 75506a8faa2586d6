"""MATLAB's MAT-files: version 5 through SciPy, version 7.3 (HDF5) where a variable is too large for that.

A file contains ``t``, a struct per signal with a field per joint (``q.elbow``), and plain variables for other channels.
Channels whose names are not valid in MATLAB are ``c1``, ``c2``, ... in a struct ``other``. The text ``flexdyn`` has the
place of each channel, in order, and the meta data (MATLAB: ``jsondecode(flexdyn)``).
"""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import Any

from flexdyn.errors import check_installed
from flexdyn.records.apart.caller import read_apart
from flexdyn.records.matlab import v5, v73
from flexdyn.records.matlab.columns import KEY
from flexdyn.records.meta import as_plain
from flexdyn.records.recording import Recording
from flexdyn.records.request import Request
from flexdyn.records.table import Table
from flexdyn.records.units import SIGNALS, split_name

LARGEST_V5 = 2**31 - 2**20
"""Largest variable of version 5 [bytes]; MATLAB itself writes at most 2 GB."""

_HDF5 = b"\x89HDF\r\n\x1a\n"
_OTHER = "other"
_NAME = re.compile(r"[A-Za-z][A-Za-z0-9_]{0,62}")
_KEYWORD = re.compile(
    "break|case|catch|classdef|continue|else|elseif|end|for|function|global"
    "|if|otherwise|parfor|persistent|return|spmd|switch|try|while"
)


def write(rec: Recording, path: Path) -> None:
    """Write version 5, or 7.3 if a variable has 2 GB or more.

    Args:
        rec: the recording.
        path: of the new file.
    """
    places = _places(list(rec.channels))
    # The list comes first, so that a truncated file lacks a variable of the list.
    listed = json.dumps({"channels": list(places.items()), "meta": as_plain(rec.meta)})
    variables: dict[str, Any] = {KEY: listed, "t": rec.t}
    for name, place in places.items():
        variable, _, field = place.partition(".")
        if field:
            variables.setdefault(variable, {})[field] = rec.channels[name]
        else:
            variables[variable] = rec.channels[name]
    columns = max((len(value) for value in variables.values() if isinstance(value, dict)), default=1)
    if rec.t.nbytes * columns >= LARGEST_V5:
        v73.write_v73(variables, path)
        return
    from scipy.io import savemat

    with open(path, "xb") as stream:
        savemat(stream, variables, long_field_names=True, oned_as="column")


def read(path: Path, request: Request) -> Table:
    """Read the requested columns in another process; without a map, all vectors of numbers, which are the channels.

    Rows count from 1, as in MATLAB.

    Args:
        path: of the file.
        request: what is wanted, and how the file is laid out.

    Raises:
        InputError: not a MAT-file, truncated, an unknown column, or one without numbers; the file crashes the library
            that reads it, or takes too long or too much memory.
        MissingExtra: version 7.3 needs h5py.
    """
    with open(path, "rb") as stream:
        head = stream.read(1024)
    if _HDF5 not in (head[:8], head[512:520]):
        return read_apart(v5.__name__, path, request)
    check_installed("h5py", "hdf5")
    return read_apart(v73.__name__, path, request)


def _places(names: list[str]) -> dict[str, str]:
    """The place of each channel: ``q.elbow``, ``power``, or ``other.c1``."""
    places: dict[str, str] = {}
    odd = 0
    for name in names:
        parts = split_name(name)
        if (parts and _is_name(parts[1])) or (_is_name(name) and name not in (*SIGNALS, KEY, _OTHER)):
            places[name] = name
        else:
            odd += 1
            places[name] = f"{_OTHER}.c{odd}"
    return places


def _is_name(text: str) -> bool:
    """Whether it is a valid name of a variable or field in MATLAB."""
    return _NAME.fullmatch(text) is not None and _KEYWORD.fullmatch(text) is None
