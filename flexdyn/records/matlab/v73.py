"""MATLAB's MAT-file version 7.3: HDF5 behind 512 bytes, arrays transposed, structs as groups.

References are not followed and nothing outside the file is opened: cell arrays and struct arrays are not read.
`read_here` is called in another process, as for HDF5 files.
"""

from __future__ import annotations

import os
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from flexdyn.arrays import Array
from flexdyn.errors import InputError
from flexdyn.records.bounds import MOST_COLUMNS, check_size
from flexdyn.records.hdf5.file import attribute, check_storage, member
from flexdyn.records.hdf5.library import library, new_file
from flexdyn.records.matlab.columns import MOST_STRUCTS, Leaf, LeafColumns
from flexdyn.records.request import Request
from flexdyn.records.table import Table, damage_named

_BLOCK = 512
_LONGEST_TEXT = 2**24


def write_v73(variables: dict[str, Any], path: Path) -> None:
    """Write columns, structs of columns and texts as MATLAB does with ``save -v7.3``.

    Args:
        variables: by name: arrays (samples,), mappings of such, and strings.
        path: of the new file.
    """
    with new_file(path, userblock_size=_BLOCK) as file:
        for name, value in variables.items():
            if isinstance(value, str):
                text = file.create_dataset(name, data=np.frombuffer(value.encode("utf-16-le"), "<u2").reshape(-1, 1))
                text.attrs["MATLAB_class"] = np.bytes_("char")
                text.attrs["MATLAB_int_decode"] = np.int32(2)
            elif isinstance(value, dict):
                group = file.create_group(name, track_order=True)
                group.attrs["MATLAB_class"] = np.bytes_("struct")
                for field, values in value.items():
                    _write_column(group, field, values)
            else:
                _write_column(file, name, value)
    words = "MATLAB 7.3 MAT-file, Platform: flexdyn, HDF5 schema 1.00 ."
    with open(path, "rb+") as stream:
        stream.write(words.encode().ljust(124) + b"\x00\x02IM")


def _write_column(group: Any, name: str, values: Array) -> None:
    group.create_dataset(name, data=values.reshape(1, -1)).attrs["MATLAB_class"] = np.bytes_("double")


def read_here(path: Path, request: Request) -> Table:
    """Read the requested columns, from one variable after the other.

    Args:
        path: of the file.
        request: what is wanted, and how the file is laid out.

    Raises:
        InputError: not an HDF5 file, truncated, links or storage outside the file, impossible sizes.
        MissingExtra: h5py is not installed.
    """
    h5py = library()
    columns = LeafColumns(request)
    with damage_named("not a MAT-file, or truncated"), h5py.File(path, "r") as file:
        reader = _Reader(h5py, os.path.getsize(path))
        names = [name for name in file if not name.startswith("#")]
        for place, name in enumerate(names):
            if columns.wants(name):
                columns.take(reader.leaves(file, name, name, 0))
            request.report((place + 1) / len(names))
        return columns.table()


class _Reader:
    """Visits the groups of a file and counts them, so that a cycle of groups ends soon."""

    def __init__(self, h5py: Any, on_disk: int) -> None:
        self._h5py, self._on_disk = h5py, on_disk
        self._met = self._bytes = 0

    def leaves(self, group: Any, link: str, name: str, depth: int) -> Iterator[Leaf]:
        """The leaves in a member of a group."""
        self._met += 1
        if depth > MOST_STRUCTS or self._met > MOST_COLUMNS:
            problem = f"structs nest deeper than {MOST_STRUCTS} or have more than {MOST_COLUMNS} fields"
            raise InputError(problem, value=name, remedy="save plainer variables")
        node = member(self._h5py, group, link)
        if isinstance(node, self._h5py.Group):
            if "MATLAB_sparse" in node.attrs:
                yield Leaf(name, "a sparse array", (), str)
                return
            for field in node:
                yield from self.leaves(node, field, f"{name}.{field}", depth + 1)
        elif isinstance(node, self._h5py.Dataset):
            yield self._leaf(node, name)

    def _leaf(self, dataset: Any, name: str) -> Leaf:
        """What a dataset holds, by its class in MATLAB."""
        check_storage(dataset, name)
        kind = attribute(self._h5py, dataset, "MATLAB_class") or ""
        shape = tuple(int(extent) for extent in reversed(dataset.shape or ()))
        if kind == "char" and dataset.dtype.kind == "u":
            return Leaf(name, "text", shape, lambda: _matlab_text(dataset, name))
        if "MATLAB_empty" in dataset.attrs or dataset.shape is None:
            return Leaf(name, "an empty array", (), str)
        if dataset.dtype.kind not in "fiu":
            words = {"cell": "a cell array", "struct": "a struct array", "function_handle": "a function handle"}
            other = "complex numbers" if dataset.dtype.names else f"of the type {dataset.dtype}"
            return Leaf(name, words.get(kind, "a cell or struct array" if dataset.dtype.hasobject else other), (), str)
        return Leaf(name, "numbers", shape, lambda: self._numbers(dataset))

    def _numbers(self, dataset: Any) -> Any:
        self._bytes += dataset.size * dataset.dtype.itemsize
        check_size(self._bytes, self._on_disk)
        return dataset[()].T


def _matlab_text(dataset: Any, name: str) -> str:
    if dataset.size > _LONGEST_TEXT:
        raise InputError("the text is longer than 16 MiB", key=name, remedy="keep long data in channels")
    return bytes(dataset[()].astype("<u2").tobytes()).decode("utf-16-le", "replace")
