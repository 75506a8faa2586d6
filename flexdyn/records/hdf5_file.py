"""HDF5: one dataset per channel and ``t``, flat or grouped by signal; nothing outside the file is opened.

The attribute ``units`` is written as text of fixed length and believed where it is; a unit that is not SI is refused.
"""

from __future__ import annotations

import math
import os
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any
from urllib.parse import quote

import numpy as np

from flexdyn.errors import InputError, MissingExtra
from flexdyn.records.meta import as_json, from_json
from flexdyn.records.request import Request
from flexdyn.records.table import RESERVED, Table, check_name, check_numbers, check_size, damage_named
from flexdyn.records.units import SIGNALS, check_unit, unit_of, usual

if TYPE_CHECKING:
    from flexdyn.records.recording import Recording

_LARGEST_CHUNK = 2**30
_UNITLESS = ("", "1", "-")


def write(rec: Recording, path: Path) -> None:
    """Write flat datasets ``t``, ``q.elbow``, ... in order, each with its unit, and meta as ``__meta__``."""
    h5py = _library()
    with h5py.File(path, "x", track_order=True, libver=("v110", "v110")) as file:
        for name, values in {"t": rec.t, **rec.channels}.items():
            plain = _plain(name)
            dataset = file.create_dataset(plain, data=values)
            dataset.attrs["units"] = _fixed(h5py, rec.unit(name))
            if plain != name:
                dataset.attrs["channel"] = _fixed(h5py, name)
        if rec.meta:
            file.create_dataset(RESERVED, data=_fixed(h5py, as_json(rec.meta)))


def read(path: Path, request: Request) -> Table:
    """Read every dataset after checking its kind and size.

    Raises:
        InputError: not an HDF5 file, cut, links or storage outside the file, wrong types or sizes.
        MissingExtra: h5py is not installed.
    """
    h5py = _library()
    table = Table()
    with damage_named("not an HDF5 file, or cut"), h5py.File(path, "r") as file:
        datasets = dict(_datasets(h5py, file))
        _check_sizes(datasets, os.path.getsize(path))
        if RESERVED in datasets:
            table.meta = from_json(_text(h5py, datasets.pop(RESERVED)))
        for name, dataset in datasets.items():
            with damage_named(f"the dataset {name} cannot be read"):
                table.add(name, dataset[()])
                _take_unit(table, name, usual(_attribute(h5py, dataset, "units")))
    return table


def _library() -> Any:
    try:
        import h5py
    except ImportError:
        raise MissingExtra("h5py", "hdf5") from None
    return h5py


def _fixed(h5py: Any, text: str) -> Any:
    """Text of fixed length in UTF-8: text of variable length lies in a heap that no checksum guards."""
    data = text.encode() or b"\0"
    return np.array(data, h5py.string_dtype(length=len(data)))


def _plain(name: str) -> str:
    """A link name for a channel: a slash would make a group, so it is written as in a URL."""
    return quote(name, safe=" ") if "/" in name or "%" in name else name


def _datasets(h5py: Any, file: Any) -> Iterator[tuple[str, Any]]:
    """Datasets by channel name: those at the root, and those one level down in a group named as a signal."""
    seen: set[str] = set()
    for link in file:
        member = _member(h5py, file, link)
        if isinstance(member, h5py.Dataset):
            found = [(_channel(h5py, member, link), member)]
        elif link in SIGNALS:
            found = [(f"{link}.{joint}", _member(h5py, member, joint)) for joint in member]
        else:
            remedy = "groups are named by signals, such as q, and hold one dataset per joint"
            raise InputError("the group is no signal", value=link, remedy=remedy)
        for name, dataset in found:
            if name not in ("t", RESERVED):
                check_name(name)
            if name in seen:
                raise InputError("the channel is there twice", key=name, remedy="rename or remove one", channel=name)
            if not isinstance(dataset, h5py.Dataset):
                raise InputError("the channel is no dataset", key=name, remedy="groups nest one deep", channel=name)
            _check_dataset(dataset, name)
            seen.add(name)
            yield name, dataset


def _member(h5py: Any, group: Any, link: str) -> Any:
    """What a link leads to, if it leads there directly: soft and external links could lead anywhere."""
    if not isinstance(group.get(link, getlink=True), h5py.HardLink):
        raise InputError("the file links elsewhere", value=link, remedy="copy the linked dataset into the file")
    return group[link]


def _channel(h5py: Any, dataset: Any, link: str) -> str:
    return (_attribute(h5py, dataset, "channel") if "%" in link else "") or link


def _attribute(h5py: Any, dataset: Any, name: str) -> str:
    """An attribute that is text of fixed length; empty if there is none or it is none.

    Text of variable length is left alone: HDF5 hangs or crashes on damaged heaps (HDFGroup/hdf5 issue 1707).
    """
    if name not in dataset.attrs:
        return ""
    kind = h5py.check_string_dtype(dataset.attrs.get_id(name).dtype)
    given = dataset.attrs[name] if kind and kind.length else b""
    return given.decode("utf-8", "replace") if isinstance(given, bytes) else ""


def _check_dataset(dataset: Any, name: str) -> None:
    """Refuse a dataset that is no column, or whose bytes lie in other files."""
    if dataset.is_virtual or dataset.external:
        remedy = "copy the samples into the file"
        raise InputError("the samples lie in another file", key=name, remedy=remedy, channel=name)
    if name != RESERVED:
        check_numbers(dataset.dtype, dataset.shape or (), name)
    if math.prod(dataset.chunks or ()) * dataset.dtype.itemsize > _LARGEST_CHUNK:
        raise InputError("a chunk is larger than 1 GiB", key=name, remedy="write smaller chunks", channel=name)


def _check_sizes(datasets: dict[str, Any], on_disk: int) -> None:
    check_size(sum(dataset.size * dataset.dtype.itemsize for dataset in datasets.values() if dataset.size), on_disk)


def _text(h5py: Any, dataset: Any) -> str:
    kind = h5py.check_string_dtype(dataset.dtype)
    if kind is None or not kind.length or dataset.shape != ():
        raise InputError(
            "meta is not one JSON text of fixed length", key=RESERVED, remedy="write it with write_recording"
        )
    return bytes(dataset[()]).decode()


def _take_unit(table: Table, name: str, unit: str) -> None:
    """Keep a unit that the file states and the channel's name does not tell; refuse one that is not SI."""
    if unit in _UNITLESS:
        return
    check_unit(name, unit)
    units = table.meta.get("units", {})
    if isinstance(units, dict) and unit != unit_of(name, units if isinstance(units.get(name, ""), str) else None):
        table.meta["units"] = {**units, name: unit}
