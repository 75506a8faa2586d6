"""Read the recordings of a command, with a progress bar on the terminal if that takes long."""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from pathlib import Path
from typing import TypeVar

from flexdyn.cli.options import span_of
from flexdyn.cli.output import console
from flexdyn.errors import InputError, placed, retold
from flexdyn.records import Recording, RecordingWarning, read_recording

T = TypeVar("T")
LARGE = 50e6
"""Files larger than this show a progress bar [bytes]."""


def load_each(paths: Sequence[Path], maps: Sequence[Path]) -> list[Recording]:
    """Read recordings by one map for all of them, or by one for each.

    Args:
        paths: of the recordings.
        maps: none, one, or as many as recordings, in their order.

    Raises:
        InputError: another number of maps, or a file with a fault.
    """
    each = _for_each(maps, len(paths), "--map", "maps")
    return [load(path, map=map) for path, map in zip(paths, each, strict=True)]


def trimmed_recordings(recordings: Sequence[Recording], spans: Sequence[str]) -> list[Recording]:
    """Spans of recordings: one for all of them, or one for each.

    Args:
        recordings: as they were read.
        spans: none, one, or as many as recordings, ``START:END`` in s.

    Raises:
        InputError: another number of spans, or one in which a recording has no two samples.
    """
    each = _for_each(spans, len(recordings), "--trim", "spans")
    return [rec if span is None else _trim(rec, span) for rec, span in zip(recordings, each, strict=True)]


def _trim(rec: Recording, span: str) -> Recording:
    start, end = span_of("--trim", span)
    with retold(file=rec.name, key="--trim"):
        return rec.trim(start, end)


def _for_each(given: Sequence[T], count: int, option: str, what: str) -> list[T | None]:
    """One entry for each recording: none, the same for all, or their own."""
    if len(given) not in (0, 1, count):
        problem = f"{len(given)} {what} for {count} recordings"
        raise InputError(problem, key=option, remedy="give one for all, or one for each in their order")
    return [*given] * (count // len(given)) if given else [None] * count


def load(path: Path, *, map: Path | None = None, name: str | None = None) -> Recording:
    """Read a recording, or several files side by side as one: ``positions.csv+currents.csv``.

    Args:
        path: of the file; or of several, with a plus sign between them: the times are those of the first.
        map: path of a channel map, of several likewise; None: the file follows the convention ``t``,
            ``<signal>.<joint>`` by itself.
        name: label; default: the file's name without suffix.

    Raises:
        InputError: a file or map with a fault, another number of maps than files, or files that do not fit together.
    """
    files = files_beside(path)
    if len(files) == 1:
        return _load(path, map=map, name=name)
    maps: list[Path | None] = [None] if map is None else list(files_beside(map))
    if len(maps) not in (1, len(files)):
        problem = f"{len(maps)} maps for {len(files)} files side by side"
        raise InputError(problem, key="--map", value=str(map), remedy="give one for all, or one+one for each in order")
    first, *others = (_load(file, map=each) for file, each in zip(files, maps * (len(files) // len(maps)), strict=True))
    with placed(file=path):
        made = first.beside(*others)
    for said in made.meta["notes"][-len(files) :]:
        warnings.warn(f"{path}: {said}", RecordingWarning, stacklevel=2)
    return made


def files_beside(path: Path) -> tuple[Path, ...]:
    """The files side by side; a single one if there is no plus sign or if a file has it in its name."""
    parts = tuple(Path(part) for part in str(path).split("+"))
    return (path,) if len(parts) == 1 or path.exists() or not all(map(str, parts)) else parts


def _load(path: Path, *, map: Path | None = None, name: str | None = None) -> Recording:
    err = console(stderr=True)
    if not err.is_terminal or not path.is_file() or path.stat().st_size < LARGE:
        return read_recording(path, map=map, name=name)
    from rich.progress import Progress

    with Progress(console=err, transient=True) as bar:
        task = bar.add_task(f"reading {path.name}", total=1.0)
        return read_recording(path, map=map, name=name, progress=lambda share: bar.update(task, completed=share))
