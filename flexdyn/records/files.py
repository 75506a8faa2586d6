"""Reading and writing recordings: the format is chosen by the file's suffix, one module per format."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path

from flexdyn.errors import InputError, did_you_mean
from flexdyn.files import replacing
from flexdyn.records import csv_file, hdf5_file, npz_file
from flexdyn.records.recording import Recording
from flexdyn.records.request import Request
from flexdyn.records.table import Table


@dataclass(frozen=True)
class Format:
    """One file format: ``read`` gives the raw table, ``write`` makes a file; libraries are imported inside them."""

    name: str
    read: Callable[[Path, Request], Table]
    write: Callable[[Recording, Path], None]


_HDF5 = Format("HDF5", hdf5_file.read, hdf5_file.write)

FORMATS: Mapping[str, Format] = {
    ".csv": Format("CSV", csv_file.read, csv_file.write),
    ".npz": Format("NPZ", npz_file.read, npz_file.write),
    ".h5": _HDF5,
    ".hdf5": _HDF5,
}

SUFFIXES: tuple[str, ...] = tuple(FORMATS)
"""Suffixes of the files that can be read and written, in any case."""


def read_recording(
    path: str | os.PathLike[str], *, name: str | None = None, progress: Callable[[float], None] | None = None
) -> Recording:
    """Read a recording (SPEC 4) from CSV, NPZ or HDF5, chosen by the suffix.

    CSV is a header ``t,q.elbow,...`` and numbers; semicolons and tabs, a byte-order mark, CRLF and comment lines (#)
    before the header are taken too. NPZ is one array per channel and ``t``. HDF5 is one dataset per channel and ``t``,
    flat (``/q.elbow``) or grouped by signal (``/q/elbow``); an attribute ``units``, text of fixed length, is refused if
    it is not SI. Nothing in a file is executed and no other file is opened.

    Args:
        path: the file.
        name: label of the recording; the file's name without suffix if left out.
        progress: called now and then with the share of the file that has been read, from 0 to 1.

    Returns:
        The recording, bit for bit as written.

    Raises:
        InputError: anything wrong with the file, in one line with row (the line, in CSV) and channel.
        MissingExtra: the suffix needs a library that is not installed.
    """
    path = Path(path)
    fmt = _format_of(path)
    try:
        if not path.is_file():
            problem = "not a regular file" if path.exists() else "no such file"
            raise InputError(problem, remedy="give the path of a recording")
        return Recording.from_table(fmt.read(path, Request(progress=progress)), path.stem if name is None else name)
    except InputError as error:
        raise error.at(file=path) from error.__cause__
    except OSError as error:
        raise InputError(f"cannot be read ({error.strerror or error})", file=path) from None
    except MemoryError:
        raise InputError("does not fit into memory", file=path, remedy="split the recording") from None


def write_recording(rec: Recording, path: str | os.PathLike[str]) -> None:
    """Write a recording; whatever goes wrong, the path holds the old file or the whole new one.

    Every double is kept bit for bit. NPZ and HDF5 keep `meta` as well (``__meta__``, JSON text); CSV is a plain table
    and drops it. HDF5 datasets carry their unit in the attribute ``units``.

    Args:
        rec: the recording.
        path: where to; the suffix chooses the format.

    Raises:
        InputError: unknown suffix, no such folder, or it cannot be written there.
        MissingExtra: the suffix needs a library that is not installed.
    """
    path = Path(path)
    fmt = _format_of(path)
    try:
        with replacing(path) as fresh:
            fmt.write(rec, fresh)
    except InputError as error:
        raise error.at(file=path) from error.__cause__
    except OSError as error:
        raise InputError(f"cannot be written ({error.strerror or error})", file=path) from None


def _format_of(path: Path) -> Format:
    suffix = path.suffix.lower()
    if suffix not in FORMATS:
        near = did_you_mean(suffix, SUFFIXES)
        known = "known: " + ", ".join(SUFFIXES)
        raise InputError(
            "unknown suffix of a recording",
            file=path,
            value=suffix,
            remedy=near if near == known else f"{near} {known}",
        )
    return FORMATS[suffix]
