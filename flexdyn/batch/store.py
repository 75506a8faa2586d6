"""The Zarr store of a study: one piece of every array a chunk of runs, each written beside and renamed.

Nothing in it depends on when, where or by how many workers it was made. A chunk of runs is there when all its pieces
are there and their checksums fit.
"""

from __future__ import annotations

import json
import os
import shutil
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from functools import cached_property
from importlib.util import find_spec
from pathlib import Path
from typing import Any

from flexdyn.batch.cases import cases_of
from flexdyn.batch.layout import StoreArray, layouts
from flexdyn.batch.metadata import FILE, array_metadata, encoded, group_metadata
from flexdyn.batch.pieces import is_whole, write_piece
from flexdyn.batch.study import Study
from flexdyn.errors import InputError, MissingExtra

STORE_FORMAT = 1


def create(study: Study, path: Path) -> Store:
    """Make the store of a study, without any run; whole or not at all.

    Args:
        study: the study.
        path: of a folder that is not there yet.

    Raises:
        InputError: it cannot be made there.
        MissingExtra: zarr is not installed.
    """
    _check_zarr()
    fresh = path.with_name(f".{path.name}.part")
    with writing(path, "give another place"):
        if fresh.exists():
            shutil.rmtree(fresh)
        try:
            _skeleton(study, fresh)
            os.rename(fresh, path)
        finally:
            shutil.rmtree(fresh, ignore_errors=True)
    return Store(path, study)


def open_store(path: str | Path) -> Store:
    """Open the store of a study, finished or not.

    Args:
        path: of its folder.

    Raises:
        InputError: there is none, or it is not one that this version reads.
        MissingExtra: zarr is not installed.
    """
    _check_zarr()
    folder = Path(path)
    if not folder.exists():
        raise InputError("there is no such store", file=path)
    try:
        attrs = json.loads((folder / FILE).read_bytes())["attributes"]
        found = attrs.get("flexdyn_batch")
        study = Study.from_text(attrs["study"]) if found == STORE_FORMAT else None
    except (OSError, ValueError, KeyError, TypeError, AttributeError, RecursionError):
        remedy = "give the path of what flexdyn batch wrote; if this is it, its zarr.json is damaged"
        raise InputError("not the store of a batch study", file=path, remedy=remedy) from None
    if study is None:
        remedy = f"this version reads format {STORE_FORMAT}"
        raise InputError("not the store of a batch study", file=path, value=found, remedy=remedy)
    return Store(folder, study, str(attrs.get("flexdyn")))


class Store:
    """The store of a study; from `create` or `open_store`.

    Args:
        path: of its folder.
        study: that it holds.
        version: of the flexdyn that made it; default: this one.
    """

    def __init__(self, path: Path, study: Study, version: str | None = None) -> None:
        from flexdyn import __version__

        self.path, self.study, self.version = path, study, version or __version__

    def write(self, chunk: int, columns: Mapping[str, Any]) -> None:
        """Write a chunk of runs; each piece is whole or not there.

        Args:
            chunk: its number.
            columns: an array over the chunk's runs for every array of the store.

        Raises:
            InputError: the disk is full, or may not be written to.
        """
        with writing(self.path, "finished chunks are stored; make room and continue with --resume"):
            for each in self._chunked:
                write_piece(self.path / each.name, chunk, each.piece, columns[each.name], each.fill)

    def has(self, chunk: int) -> bool:
        """Whether every piece of a chunk is there and whole.

        Args:
            chunk: its number.
        """
        return all(is_whole(self.path / each.name, chunk, len(each.piece)) for each in self._chunked)

    def missing(self) -> Iterator[int]:
        """The chunks that are not there or not whole, one after the other."""
        return (chunk for chunk in range(self.study.chunks) if not self.has(chunk))

    def sweep(self) -> None:
        """Remove pieces that a killed process left half written beside their places.

        Raises:
            InputError: the folder may not be written to.
        """
        with writing(self.path, "it must be writable to continue"):
            for left in self.path.rglob("*.partial"):
                left.unlink()

    def mend(self) -> None:
        """Sweep, and make good what is damaged of all that follows from the study alone: metadata and coordinates.

        Raises:
            InputError: the folder may not be written to.
        """
        fresh = self.path.with_name(f".{self.path.name}.part")
        self.sweep()
        with writing(self.path, "it must be writable to continue"):
            shutil.rmtree(fresh, ignore_errors=True)
            try:
                _skeleton(self.study, fresh)
                for made in fresh.rglob("*"):
                    place = self.path / made.relative_to(fresh)
                    if made.is_file() and not (place.is_file() and place.read_bytes() == made.read_bytes()):
                        place.parent.mkdir(exist_ok=True)
                        os.replace(made, place)
            finally:
                shutil.rmtree(fresh, ignore_errors=True)

    @cached_property
    def _chunked(self) -> tuple[StoreArray, ...]:
        """The arrays that are written chunk by chunk; status last."""
        return tuple(each for each in layouts(cases_of(self.study)) if each.values is None)


@contextmanager
def writing(path: Path, remedy: str) -> Iterator[None]:
    """What the disk refuses, as one line.

    Args:
        path: that is written to.
        remedy: what to do about it.

    Raises:
        InputError: it is refused.
    """
    try:
        yield
    except OSError as error:
        raise InputError(f"cannot be written ({error.strerror or error})", file=path, remedy=remedy) from None


def _skeleton(study: Study, folder: Path) -> None:
    """Everything of a store that follows from the study alone: metadata and coordinates."""
    from flexdyn import __version__

    arrays = tuple(layouts(cases_of(study)))
    folder.mkdir()
    for each in arrays:
        place = folder / each.name
        place.mkdir()
        (place / FILE).write_bytes(encoded(array_metadata(each)))
        if each.values is not None:
            write_piece(place, 0, each.piece, each.values, each.fill)
    attrs = {"flexdyn_batch": STORE_FORMAT, "flexdyn": __version__, "study": study.to_text()}
    (folder / FILE).write_bytes(encoded(group_metadata(attrs, arrays)))


def _check_zarr() -> None:
    """Say at once what the last line of a long study would be about.

    Raises:
        MissingExtra: zarr is not installed.
    """
    if find_spec("zarr") is None:
        raise MissingExtra("zarr", "batch")
