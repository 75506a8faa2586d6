"""The Zarr store of a study: one piece of every array a chunk of runs, each written beside and renamed.

Nothing in it depends on when, where or by how many workers it was made. A chunk of runs is there when all its pieces
are there and their checksums fit.
"""

from __future__ import annotations

import os
import shutil
import warnings
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from flexdyn.batch.cases import Cases, cases_of
from flexdyn.batch.layout import COORDINATES, NOT_DONE, Layout, layouts
from flexdyn.batch.pieces import LEVEL, write_piece
from flexdyn.batch.study import Study
from flexdyn.errors import InputError, MissingExtra

FORMAT = 1


def create(study: Study, path: Path) -> Store:
    """Make the store of a study, without any run; whole or not at all.

    Args:
        study: the study.
        path: of a folder that is not there yet.

    Raises:
        InputError: it cannot be made there.
        MissingExtra: zarr is not installed.
    """
    fresh = path.with_name(f".{path.name}.part")
    with writing(path, "give another place"):
        if fresh.exists():
            shutil.rmtree(fresh)
        try:
            _skeleton(cases_of(study), fresh)
            os.rename(fresh, path)
        finally:
            shutil.rmtree(fresh, ignore_errors=True)
    return Store(path)


def open_store(path: str | Path) -> Store:
    """Open the store of a study, finished or not.

    Args:
        path: of its folder.

    Raises:
        InputError: there is none, or it is not one that this version reads.
        MissingExtra: zarr is not installed.
    """
    folder = Path(path)
    if not folder.exists():
        raise InputError("there is no such store", file=path)
    store = Store(folder)
    if store.attrs.get("flexdyn_batch") != FORMAT:
        found = store.attrs.get("flexdyn_batch")
        remedy = f"this version reads format {FORMAT}"
        raise InputError("not the store of a batch study", file=path, value=found, remedy=remedy)
    return store


class Store:
    """The store of a study; from `create` or `open_store`.

    Args:
        path: of its folder.
    """

    def __init__(self, path: Path) -> None:
        self.path = path

    @cached_property
    def attrs(self) -> Mapping[str, Any]:
        """Format, version and the study's text.

        Raises:
            InputError: the folder is no Zarr group.
        """
        zarr = _zarr()
        try:
            return dict(zarr.open_group(self.path, mode="r", zarr_format=3, use_consolidated=False).attrs)
        except (FileNotFoundError, ValueError, KeyError, TypeError, OSError):
            remedy = "give the path of what flexdyn batch wrote; if this is it, its zarr.json is damaged"
            raise InputError("not the store of a batch study", file=self.path, remedy=remedy) from None

    @cached_property
    def study(self) -> Study:
        """The study that it was made for."""
        return Study.from_text(self.attrs["study"])

    @property
    def version(self) -> str:
        """Of the flexdyn that made it."""
        return str(self.attrs["flexdyn"])

    def write(self, chunk: int, columns: Mapping[str, Any]) -> None:
        """Write a chunk of runs; each piece is whole or not there.

        Args:
            chunk: its number.
            columns: an array over the chunk's runs for every array of the store.

        Raises:
            InputError: the disk is full, or may not be written to.
        """
        with writing(self.path, "what is done stays; make room and go on with --resume"):
            for name, array in self._arrays.items():
                write_piece(self.path / name, chunk, array.chunks, columns[name], array.fill_value)

    def has(self, chunk: int) -> bool:
        """Whether every piece of a chunk is there and whole.

        Args:
            chunk: its number.
        """
        runs = self.study.bounds(chunk)
        for name, array in self._arrays.items():
            if not (self.path / name / ".".join(["c", str(chunk), *["0"] * (array.ndim - 1)])).exists():
                return False
            try:
                array[runs.start : runs.stop]
            except (ValueError, RuntimeError, OSError):  # the checksum, the codec, the disk
                return False
        return True

    def missing(self) -> Iterator[int]:
        """The chunks that are not there or not whole, one after the other."""
        return (chunk for chunk in range(self.study.chunks) if not self.has(chunk))

    def sweep(self) -> None:
        """Remove pieces that a killed process left half written beside their places.

        Raises:
            InputError: the folder may not be written to.
        """
        with writing(self.path, "it must be writable to go on"):
            for left in self.path.rglob("*.partial"):
                left.unlink()

    def mend(self, study: Study) -> None:
        """Sweep, and make good what is damaged of all that follows from the study alone: metadata and coordinates.

        Args:
            study: the same one, maybe moved to another place since.

        Raises:
            InputError: the folder may not be written to.
        """
        fresh = self.path.with_name(f".{self.path.name}.part")
        self.sweep()
        with writing(self.path, "it must be writable to go on"):
            shutil.rmtree(fresh, ignore_errors=True)
            try:
                _skeleton(cases_of(study), fresh)
                for made in fresh.rglob("*"):
                    place = self.path / made.relative_to(fresh)
                    if made.is_file() and not (place.is_file() and place.read_bytes() == made.read_bytes()):
                        place.parent.mkdir(exist_ok=True)
                        os.replace(made, place)
            finally:
                shutil.rmtree(fresh, ignore_errors=True)

    @cached_property
    def _arrays(self) -> dict[str, Any]:
        """What is written chunk by chunk; status last."""
        group = _zarr().open_group(self.path, mode="r+", zarr_format=3)
        arrays = {name: array for name, array in group.arrays() if name not in COORDINATES}
        return dict(sorted(arrays.items(), key=lambda entry: entry[0] == "status"))


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


def _skeleton(cases: Cases, folder: Path) -> None:
    """Everything of a store that follows from the study alone: metadata and coordinates."""
    import flexdyn

    attrs = {"flexdyn_batch": FORMAT, "flexdyn": flexdyn.__version__, "study": cases.study.to_text()}
    group = _zarr().open_group(folder, mode="w-", zarr_format=3, attributes=attrs)
    for each in layouts(cases):
        array = _array(group, each, cases.study.chunk)
        if each.values is not None:
            array[:] = each.values
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # consolidated metadata are zarr's own addition to the format
        _zarr().consolidate_metadata(group.store)


def _array(group: Any, each: Layout, chunk: int) -> Any:
    from zarr.codecs import Crc32cCodec, ZstdCodec

    runs = each.shape[0] if each.values is not None else chunk
    fill = {"str": NOT_DONE, "float64": np.nan, "int64": 0}
    return group.create_array(
        each.name,
        shape=each.shape,
        chunks=(runs, *each.shape[1:]),
        dtype=each.dtype,
        fill_value=fill[each.dtype],
        dimension_names=each.dims,
        attributes=dict(each.attrs),
        compressors=[ZstdCodec(level=LEVEL), Crc32cCodec()],
        chunk_key_encoding={"name": "default", "separator": "."},
        config={"write_empty_chunks": True},
    )


def _zarr() -> Any:
    try:
        import zarr
    except ImportError:
        raise MissingExtra("zarr", "batch") from None
    return zarr
