"""How a diagnosis came about: spans of recordings, files that were read, the version and the command."""

from __future__ import annotations

import datetime
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from importlib.metadata import version
from pathlib import Path
from typing import Literal

Role = Literal["fit", "test"]


@dataclass(frozen=True)
class RecordingSpan:
    """A span of a recording and what it was used for.

    Attributes:
        file: name of the recording.
        role: ``fit`` (estimates and cross-validation) or ``test`` (the verdict alone).
        start: of the span, in the recording's own time [s].
        end: of the span [s].
        rate: samples per second [Hz].
        noise: standard deviation of the sensor's noise by channel, in the channel's unit.
        samples: number of samples.
        channels: of the recording, also those that the diagnosis does not use.
    """

    file: str
    role: Role
    start: float
    end: float
    rate: float
    noise: Mapping[str, float] = field(default_factory=dict)
    samples: int = 0
    channels: tuple[str, ...] = ()


@dataclass(frozen=True)
class File:
    """A file that was read.

    Attributes:
        path: as it was given.
        use: model, fit or test.
        bytes: its size.
        modified: when it was last changed, ISO 8601 with the zone.
    """

    path: str
    use: Role | str
    bytes: int
    modified: str

    @classmethod
    def of(cls, path: Path, use: str) -> File | None:
        """A file as it is now; None: there is none, as of a model that is known by its name."""
        try:
            # The folder of a ROS 2 bag is as large, and as new, as what lies in it.
            stats = [each.stat() for each in sorted(path.rglob("*"))] if path.is_dir() else [path.stat()]
        except OSError:
            return None
        changed = datetime.datetime.fromtimestamp(max((each.st_mtime for each in stats), default=0.0)).astimezone()
        return cls(str(path), use, sum(each.st_size for each in stats), changed.isoformat(timespec="seconds"))


@dataclass(frozen=True)
class Record:
    """How a diagnosis came about.

    Attributes:
        version: of flexdyn.
        date: of its end, ISO 8601 with the zone.
        command: the command line; empty: it was called from Python.
        files: that were read; none are known of recordings that were made in Python.
    """

    version: str
    date: str
    command: str = ""
    files: tuple[File, ...] = ()


def record(command: str = "", files: Iterable[File | None] = ()) -> Record:
    """Of now, by this version."""
    date = datetime.datetime.now().astimezone().isoformat(timespec="seconds")
    return Record(version("flexdyn"), date, command, tuple(each for each in files if each is not None))
