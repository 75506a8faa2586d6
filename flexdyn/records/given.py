"""Convert anything that a user may give as a recording."""

from __future__ import annotations

import os
from collections.abc import Iterable, Mapping
from typing import Any

from flexdyn.errors import InputError
from flexdyn.records.files import read_recording
from flexdyn.records.recording import Recording
from flexdyn.records.suggestion import asked_back


def as_recording(given: Any, key: str | None = None, *, signals: bool = False) -> Recording:
    """Convert a recording, a run, the path of a recording, a pandas.DataFrame or an xarray.Dataset to a recording.

    Args:
        given: one of them.
        key: its name in errors.
        signals: whether to refuse channels of which none is a signal of a joint although some names are similar.

    Raises:
        InputError: something else, a file that cannot be read, or channels that are refused.
    """
    made = given if isinstance(given, Recording) else _made(given, key)
    if signals and (question := asked_back(made.channels)):
        raise InputError("no channel is a signal of a joint", key=made.name or key, remedy=question)
    return made


def as_recordings(given: Any, key: str = "recordings") -> tuple[Recording, ...]:
    """Convert one or several objects that `as_recording` accepts; they must have signals of joints.

    Args:
        given: one object or a sequence.
        key: for the message.

    Raises:
        InputError: likewise.
    """
    if isinstance(given, Recording | str | os.PathLike) or _table_library(given) or hasattr(given, "to_recording"):
        return (as_recording(given, key, signals=True),)
    if not isinstance(given, Iterable) or isinstance(given, Mapping):
        raise _no_recording(given, key)
    return tuple(as_recording(each, f"{key}[{i}]", signals=True) for i, each in enumerate(given))


def _made(given: Any, key: str | None) -> Recording:
    """A recording from a path, a table of pandas, a dataset of xarray, or what offers one."""
    if isinstance(given, str | os.PathLike):
        return read_recording(given)
    library = _table_library(given)
    if library == "pandas":
        return Recording.from_pandas(given)
    if library == "xarray":
        return Recording.from_xarray(given)
    made = given.to_recording() if hasattr(given, "to_recording") else None
    if not isinstance(made, Recording):
        raise _no_recording(given, key)
    return made


def _table_library(given: Any) -> str:
    """Library of a table; empty for anything else. The libraries need not be installed for that."""
    kind = type(given)
    known = {("pandas", "DataFrame"), ("xarray", "Dataset")}
    library = kind.__module__.partition(".")[0]
    return library if (library, kind.__name__) in known else ""


def _no_recording(given: Any, key: str | None) -> InputError:
    remedy = "give what fd.simulate or fd.read_recording returned, a path, or a pandas.DataFrame"
    return InputError("neither a run nor a recording", key=key, value=given, remedy=remedy)
