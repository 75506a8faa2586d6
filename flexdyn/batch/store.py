"""The Zarr store of a study: every array has one piece for each chunk of runs, written to a temporary file and renamed.

Its content does not depend on time, machine or number of workers. A chunk of runs is complete if all its pieces exist
with correct checksums.
"""

from __future__ import annotations

import os
import shutil
import warnings
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from functools import cached_property
from pathlib import Path
from typing import Any

from flexdyn.batch.cases import cases_of
from flexdyn.batch.layout import StoreArray, layouts
from flexdyn.batch.pieces import LEVEL, is_whole, write_piece
from flexdyn.batch.stored_study import MAX_STORE_BYTES, MAX_STUDY_LETTERS, stored_study
from flexdyn.batch.study import Study
from flexdyn.errors import InputError, check_installed
from flexdyn.io.json_file import read_json

STORE_FORMAT = 1
_FILE = "zarr.json"


def create(study: Study, path: Path) -> Store:
    """Make the store of a study without runs, completely or not at all.

    Args:
        study: the study.
        path: of a folder that does not exist yet.

    Raises:
        InputError: it cannot be made there, or is too large to be opened again.
        MissingExtra: zarr is not installed.
    """
    check_installed("zarr", "batch")  # at the start, not at the end of a long study
    if len(study.to_text()) > MAX_STUDY_LETTERS:
        problem = f"the study is longer than the {MAX_STUDY_LETTERS} letters that a store can have"
        raise InputError(problem, file=path, remedy="vary less, or give the values of a grid as a distribution")
    with writing(path, "give another place"), _skeleton(study, path) as fresh:
        if (fresh / _FILE).stat().st_size > MAX_STORE_BYTES:
            problem = f"the metadata of its arrays are larger than {MAX_STORE_BYTES} bytes"
            raise InputError(problem, file=path, remedy="vary fewer numbers")
        os.rename(fresh, path)
    return Store(path, study)


def open_store(path: str | Path) -> Store:
    """Open the store of a study, finished or not.

    Args:
        path: of its folder.

    Raises:
        InputError: there is none, or this version cannot read it.
        MissingExtra: zarr is not installed.
    """
    check_installed("zarr", "batch")  # at the start, not at the end of a long study
    folder = Path(path)
    if not folder.exists():
        raise InputError("there is no such store", file=path)
    try:
        attrs = read_json(folder / _FILE, MAX_STORE_BYTES)["attributes"]
        found = attrs.get("flexdyn_batch")
        study = stored_study(attrs["study"]) if found == STORE_FORMAT else None
    except (InputError, KeyError, TypeError, AttributeError, IndexError):
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
        study: whose runs it has.
        version: of the flexdyn that made it; default: this one.
    """

    def __init__(self, path: Path, study: Study, version: str | None = None) -> None:
        from flexdyn import __version__

        self.path, self.study, self.version = path, study, version or __version__

    def write(self, chunk: int, columns: Mapping[str, Any]) -> None:
        """Write a chunk of runs; each piece is written completely or not at all.

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
        """Whether every piece of a chunk exists and is complete.

        Args:
            chunk: its number.
        """
        return all(is_whole(self.path / each.name, chunk, len(each.piece)) for each in self._chunked)

    def missing(self) -> Iterator[int]:
        """Yield the chunks that are missing or incomplete."""
        return (chunk for chunk in range(self.study.chunks) if not self.has(chunk))

    def sweep(self) -> None:
        """Remove incomplete temporary files of a killed process.

        Raises:
            InputError: the folder may not be written to.
        """
        with writing(self.path, "it must be writable to continue"):
            for left in self.path.rglob("*.partial"):
                left.unlink()

    def mend(self) -> None:
        """Remove temporary files, and repair damaged metadata and coordinates, which follow from the study alone.

        Raises:
            InputError: the folder may not be written to.
        """
        self.sweep()
        with writing(self.path, "it must be writable to continue"), _skeleton(self.study, self.path) as fresh:
            for made in fresh.rglob("*"):
                place = self.path / made.relative_to(fresh)
                if made.is_file() and not (place.is_file() and place.read_bytes() == made.read_bytes()):
                    place.parent.mkdir(exist_ok=True)
                    os.replace(made, place)

    @cached_property
    def _chunked(self) -> tuple[StoreArray, ...]:
        """The arrays that are written chunk by chunk; status last."""
        return tuple(each for each in layouts(cases_of(self.study)) if each.values is None)


@contextmanager
def writing(path: Path, remedy: str) -> Iterator[None]:
    """Convert an error of the disk to one line.

    Args:
        path: that is written to.
        remedy: what the user can do.

    Raises:
        InputError: the disk cannot be written to.
    """
    try:
        yield
    except OSError as error:
        raise InputError(f"cannot be written ({error.strerror or error})", file=path, remedy=remedy) from None


@contextmanager
def _skeleton(study: Study, path: Path) -> Iterator[Path]:
    """A folder beside `path` with the parts of a store that follow from the study alone: metadata and coordinates."""
    from flexdyn import __version__

    arrays = tuple(layouts(cases_of(study)))
    folder = path.with_name(f".{path.name}.part")
    if folder.exists():
        shutil.rmtree(folder)
    try:
        attrs = {"flexdyn_batch": STORE_FORMAT, "flexdyn": __version__, "study": study.to_text()}
        make_arrays(folder, attrs, arrays)
        for each in arrays:
            if each.values is not None:
                write_piece(folder / each.name, 0, each.piece, each.values, each.fill)
        yield folder
    finally:
        shutil.rmtree(folder, ignore_errors=True)


def make_arrays(folder: Path, attrs: Mapping[str, Any], arrays: Sequence[StoreArray]) -> None:
    """Make a group of empty arrays; its own file has the metadata of all of them, so that a reader needs one file.

    Args:
        folder: of the group, which does not exist yet.
        attrs: of the group.
        arrays: in it.
    """
    import zarr
    from zarr.codecs import Crc32cCodec, ZstdCodec

    group = zarr.create_group(folder, zarr_format=3, attributes=dict(attrs))
    for each in arrays:
        group.create_array(
            each.name,
            shape=each.shape,
            chunks=each.piece,
            dtype=each.dtype,
            fill_value=each.fill,
            dimension_names=each.dims,
            attributes=dict(each.attrs),
            compressors=[ZstdCodec(level=LEVEL), Crc32cCodec()],
            chunk_key_encoding={"name": "default", "separator": "."},
        )
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # consolidated metadata are not part of version 3 of the format yet
        zarr.consolidate_metadata(group.store)
