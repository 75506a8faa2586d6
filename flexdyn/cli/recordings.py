"""Reading the recordings that commands are given, with a bar on the terminal where that takes long."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from flexdyn.cli.output import console
from flexdyn.errors import InputError
from flexdyn.records import Recording, read_recording

LARGE = 50e6
"""Bytes from which reading a file shows how far it is."""


def load_each(paths: Sequence[Path], maps: Sequence[Path]) -> list[Recording]:
    """Read recordings by one map for all of them, or by one for each.

    Args:
        paths: of the recordings.
        maps: none, one, or as many as recordings, in their order.

    Raises:
        InputError: another number of maps, or a file that is wrong.
    """
    if len(maps) not in (0, 1, len(paths)):
        problem = f"{len(maps)} maps for {len(paths)} recordings"
        raise InputError(problem, key="--map", remedy="give one for all, or one for each in their order")
    each = list(maps) if len(maps) == len(paths) else [maps[0] if maps else None] * len(paths)
    return [load(path, map=map) for path, map in zip(paths, each, strict=True)]


def load(path: Path, *, map: Path | None = None, name: str | None = None) -> Recording:
    """Read a recording.

    Args:
        path: of the file.
        map: path of a channel map; None: the file follows the convention ``t``, ``<signal>.<joint>`` by itself.
        name: label; default: the file's name without suffix.
    """
    err = console(stderr=True)
    if not err.is_terminal or not path.is_file() or path.stat().st_size < LARGE:
        return read_recording(path, map=map, name=name)
    from rich.progress import BarColumn, Progress, TaskProgressColumn, TextColumn, TimeRemainingColumn

    columns = (TextColumn("{task.description}"), BarColumn(), TaskProgressColumn(), TimeRemainingColumn())
    with Progress(*columns, console=err, transient=True) as bar:
        task = bar.add_task(f"reading {path.name}", total=1.0)
        return read_recording(path, map=map, name=name, progress=lambda share: bar.update(task, completed=share))
