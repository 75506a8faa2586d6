"""Reading and writing recordings: the format is chosen by the file's suffix, one module per format."""

from __future__ import annotations

import os
import warnings
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

from flexdyn.errors import InputError, placed
from flexdyn.io.files import check_suffix, is_file, replacing
from flexdyn.records import npz_file, parquet_file
from flexdyn.records.bounds import MOST_FILE
from flexdyn.records.channelmap.apply import apply_map
from flexdyn.records.channelmap.description import ChannelMap
from flexdyn.records.channelmap.file import read_map
from flexdyn.records.csv import file as csv_file
from flexdyn.records.hdf5 import file as hdf5_file
from flexdyn.records.matlab import file as mat_file
from flexdyn.records.notices import RecordingWarning
from flexdyn.records.recording import Recording
from flexdyn.records.repairs import repaired, repairs_of
from flexdyn.records.request import Request
from flexdyn.records.ros import read as read_bag
from flexdyn.records.ros import write as write_bag
from flexdyn.records.signals.gaps import gaps_text
from flexdyn.records.suggestion import asked_back
from flexdyn.records.table import Table


@dataclass(frozen=True)
class Format:
    """One file format: ``read`` gives the raw table, ``write`` makes a file; libraries are imported inside them."""

    read: Callable[[Path, Request], Table]
    write: Callable[[Recording, Path], None]


_CSV = Format(csv_file.read, csv_file.write)
_HDF5 = Format(hdf5_file.read, hdf5_file.write)

FORMATS: Mapping[str, Format] = {
    ".csv": _CSV,
    ".npz": Format(npz_file.read, npz_file.write),
    ".h5": _HDF5,
    ".hdf5": _HDF5,
    ".parquet": Format(parquet_file.read, parquet_file.write),
    ".mat": Format(mat_file.read, mat_file.write),
    ".txt": _CSV,
    ".bag": Format(read_bag, partial(write_bag, suffix=".bag")),
    ".mcap": Format(read_bag, partial(write_bag, suffix=".mcap")),
    ".db3": Format(read_bag, partial(write_bag, suffix=".db3")),
    ".tsv": Format(csv_file.read, partial(csv_file.write, delimiter="\t")),
}

SUFFIXES: tuple[str, ...] = tuple(FORMATS)
"""Suffixes of the files that can be read and written, in any case."""


def read_recording(
    path: str | os.PathLike[str],
    *,
    map: str | os.PathLike[str] | ChannelMap | None = None,
    repair: Iterable[str | Mapping[str, Any]] = (),
    name: str | None = None,
    progress: Callable[[float], None] | None = None,
) -> Recording:
    """Read a recording: the suffix tells the format, in any case; the folder of a ROS 2 bag is read as one.

    Without a map a file holds ``t`` [s] and channels named ``<signal>.<joint>``:

    * CSV (.csv, .txt, .tsv): a header ``t,q.elbow,...`` and numbers; semicolons, tabs and spaces, quotes, a byte-order
      mark, CRLF and comment lines (#) before the header are taken too, and units behind the names (``q.elbow [rad]``).
      An empty cell is a gap, to be repaired. Dates with times of day are counted from the first.
    * NPZ: one array per channel and ``t``; no pickle is loaded.
    * HDF5 (.h5, .hdf5): one dataset per channel and ``t``, flat (``/q.elbow``) or grouped by signal (``/q/elbow``).
    * Parquet: one column per channel and ``t``, as pandas writes them.
    * MAT (v5 and v7.3): ``t``, a struct per signal with a field per joint, and vectors.
    * ROS 1 bags, ROS 2 bags, MCAP (.bag, .db3, .mcap): the only topic of joint states: position is q, velocity v,
      effort tau; of a controller's state, feedback gives q and v, output tau. ``meta["notes"]`` says what was assumed,
      ``meta["start_ns"]`` from when stamps of the time of day are counted.

    With a map the file may have any columns; columns of two-dimensional arrays are named ``q[:,0]`` (NPZ, HDF5) or
    ``rec.pos(1,:)`` (MAT), fields of messages ``position.elbow``, other topics ``/left/states.position.elbow``.

    Units that are not SI are refused unless a map converts them, faults of the samples (numbers that are not finite,
    times that do not increase) unless a repair is requested. Nothing in a file is executed, no other file is opened.

    Args:
        path: the file, or the folder of a ROS 2 bag.
        map: a channel map or the path of one, for files that do not follow the convention by themselves: names, units,
            gears, signs, couplings and clocks of the raw columns; ``rec.meta["map"]`` keeps it.
        repair: repairs to make, in order: ``sort_time``, ``drop_duplicate_times``, ``drop_backwards``, ``drop_nan``,
            ``fill_nan`` (gaps up to 0.1 s, else ``{"fill_nan": {"longest": 0.5}}``); those of the map come first.
            ``rec.meta["repairs"]`` gives the number of rows that each changed.
        name: label of the recording; default: the file's name without suffix.
        progress: called from time to time with the share of the file that has been read, from 0 to 1.

    Returns:
        The recording; without map and repair, a file of `write_recording` is read back bit for bit.

    Warns:
        RecordingWarning: something was guessed, which is in ``rec.meta["notes"]``; the data have gaps
            (`Recording.gaps`); or no channel is a signal of a joint although some names are similar.

    Raises:
        InputError: a fault of the file, the map or a repair, in one line with row (in CSV: line) and channel.
        MissingExtra: the suffix needs a library that is not installed.

    Example:
        >>> run = fd.simulate(fd.load_model("scara_two_link"), duration=0.5, v0=[1.0, -2.0])
        >>> run.save("run.npz")
        >>> fd.read_recording("run.npz").joints
        ('shoulder', 'elbow')
    """
    made, said = _read(Path(path), map, repair, name, progress)
    for text in (*said, *_doubts(made)):
        warnings.warn(f"{Path(path)}: {text}", RecordingWarning, stacklevel=2)
    return made


def _read(path: Path, map: Any, repair: Any, name: str | None, progress: Any) -> tuple[Recording, list[str]]:
    """The recording in a file, as its map and the repairs make it, and what its reader guessed."""
    fmt = _format_of(path)
    channel_map = map if map is None or isinstance(map, ChannelMap) else read_map(map)
    asked = repairs_of(repair)
    with placed(file=path), _readable(path):
        request = Request(progress=progress) if channel_map is None else channel_map.request(progress)
        table = fmt.read(path, request)
        table = repaired(table, asked) if channel_map is None else apply_map(table, channel_map, asked)
        if table.said:
            table.meta["notes"] = [*table.meta.get("notes", ()), *table.said]
        return Recording.from_table(table, path.stem if name is None else name), table.said


def _doubts(rec: Recording) -> Iterator[str]:
    """Gaps in time, and names that are no signals although they are similar."""
    if gaps := gaps_text(rec.t):
        yield gaps
    if question := asked_back(rec.channels):
        yield f"no channel is a signal of a joint: {question}"


def is_recording(path: str | os.PathLike[str]) -> bool:
    """Whether a path has the suffix of a recording, or is the folder of a ROS 2 bag; nothing is read."""
    path = Path(path)
    return path.suffix.lower() in FORMATS or _is_bag_folder(path)


def write_recording(rec: Recording, path: str | os.PathLike[str]) -> None:
    """Write a recording; after an error the path has either the old file or the complete new one.

    Every double is kept bit for bit, and also `meta`, except in CSV, which is a plain table.

    * CSV: the shortest digits that determine every double; .tsv with tabs.
    * NPZ, HDF5, Parquet: one array, dataset or column per channel; HDF5 and Parquet carry units.
    * MAT: a struct per signal with a field per joint; version 5, or 7.3 where a variable has 2 GB.
    * Bags (.bag, .mcap, .db3): JointState on ``/joint_states`` (q, v, tau), ``/motor_states`` (theta, omega,
      tau_applied) and ``/transmission_states`` (tau_s); other channels on ``/flexdyn/channels``. Stamps are times
      rounded to nanoseconds.

    Args:
        rec: the recording.
        path: of the file; the suffix chooses the format.

    Raises:
        InputError: an unknown suffix, no such folder, a place that cannot be written to, or, for a bag, two samples
            within one nanosecond.
        MissingExtra: the suffix needs a library that is not installed.

    Example:
        >>> rec = fd.Recording([0.0, 0.1, 0.2], {"q.elbow": [0.0, 0.1, 0.3]})
        >>> fd.write_recording(rec, "log.csv")
        >>> fd.read_recording("log.csv") == rec
        True
    """
    path = Path(path)
    fmt = _format_of(path)
    with placed(file=path), replacing(path) as fresh:
        fmt.write(rec, fresh)


@contextmanager
def _readable(path: Path) -> Iterator[None]:
    """Check a file before it is read; errors of the disk, and of too little memory, become one line."""
    try:
        if not path.is_file() and not _is_bag_folder(path):
            problem = "not a regular file" if path.exists() else "no such file"
            raise InputError(problem, remedy="give the path of a recording")
        if path.stat().st_size > MOST_FILE:
            raise InputError(f"the file is larger than {MOST_FILE} bytes", remedy="split the recording")
        yield
    except OSError as error:
        raise InputError(f"cannot be read ({error.strerror or error})") from None
    except MemoryError:
        raise InputError("does not fit into memory", remedy="split the recording") from None


def _is_bag_folder(path: Path) -> bool:
    """Whether this is the folder of a ROS 2 bag."""
    return is_file(path / "metadata.yaml")


def _format_of(path: Path) -> Format:
    if _is_bag_folder(path):
        return FORMATS[".db3"]
    check_suffix(path, SUFFIXES, "a recording")
    return FORMATS[path.suffix.lower()]
