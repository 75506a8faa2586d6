"""HDF5: one dataset per channel and ``t``, flat or grouped by signal; nothing outside the file is opened.

Another process reads the files, because HDF5 crashes or hangs on some damaged ones (HDFGroup/hdf5 issue 1707 is one of
many): see `flexdyn.records.apart`.
"""

from __future__ import annotations

import math
import os
from collections.abc import Iterator
from pathlib import Path
from typing import Any
from urllib.parse import quote

import numpy as np

from flexdyn.errors import InputError, check_installed
from flexdyn.records.apart.caller import read_apart
from flexdyn.records.array_columns import parts_of
from flexdyn.records.bounds import check_count, check_size
from flexdyn.records.hdf5.library import library, new_file
from flexdyn.records.meta import as_json, from_json
from flexdyn.records.recording import Recording
from flexdyn.records.request import Request
from flexdyn.records.table import RESERVED, Table, check_name, check_new, damage_named
from flexdyn.records.units import SIGNALS

_LARGEST_CHUNK = 2**30
_LONGEST_UNIT = 999


def write(rec: Recording, path: Path) -> None:
    """Write flat datasets ``t``, ``q.elbow``, ... in order, each with its unit, and meta as ``__meta__``.

    Args:
        rec: the recording.
        path: of the new file.
    """
    h5py = library()
    with new_file(path) as file:
        for name, values in {"t": rec.t, **rec.channels}.items():
            plain = _link_name(name)
            dataset = file.create_dataset(plain, data=values)
            dataset.attrs["units"] = _fixed(h5py, rec.unit(name))
            if plain != name:
                dataset.attrs["channel"] = _fixed(h5py, name)
        if rec.meta:
            file.create_dataset(RESERVED, data=_fixed(h5py, as_json(rec.meta)))


def read(path: Path, request: Request) -> Table:
    """Call `read_here` in another process.

    Args:
        path: of the file.
        request: what is wanted, and how the file is laid out.

    Raises:
        InputError: as `read_here`; the file crashes HDF5, or takes too long or too much memory.
        MissingExtra: h5py is not installed.
    """
    check_installed("h5py", "hdf5")
    return read_apart(__name__, path, request)


def read_here(path: Path, request: Request) -> Table:
    """Read datasets after checking their kind and size.

    Without a map they are flat or grouped by signal. A map finds them anywhere, such as ``robot/arm/q``, and takes
    ``robot/arm/q[:,0]``, the first column of a two-dimensional one.

    Args:
        path: of the file.
        request: what is wanted, and how the file is laid out.

    Raises:
        InputError: not an HDF5 file, truncated, links or storage outside the file, wrong types or sizes.
        MissingExtra: h5py is not installed.
    """
    h5py = library()
    table = Table()
    with damage_named("not an HDF5 file, or truncated"), h5py.File(path, "r") as file:
        datasets = dict(_anywhere(h5py, file) if request.mapped else _datasets(h5py, file))
        meta = datasets.pop(RESERVED, None)
        if meta is not None:
            check_storage(meta, RESERVED)
            table.meta = from_json(_dataset_text(h5py, meta))
        parts = parts_of(datasets if request.columns is None else request.columns, datasets)
        wanted = {part.array: datasets[part.array] for part in parts}
        for name, dataset in wanted.items():
            check_storage(dataset, name)
        sizes = (dataset.size * dataset.dtype.itemsize for dataset in wanted.values() if dataset.size)
        check_size(sum(sizes), os.path.getsize(path))
        for done, part in enumerate(parts):
            dataset = wanted[part.array]
            part.check(dataset.dtype, dataset.shape or ())
            with damage_named(f"the dataset {part.array} cannot be read"):
                table.add(part.key, part.of(dataset))
                table.units[part.key] = attribute(h5py, dataset, "units")
            request.report((done + 1) / len(parts))
    return table


def _fixed(h5py: Any, text: str) -> Any:
    """Text of fixed length in UTF-8: text of variable length is in a heap without checksum."""
    data = text.encode() or b"\0"
    return np.array(data, h5py.string_dtype(length=len(data)))


def _link_name(name: str) -> str:
    """A link name for a channel: a slash would make a group, so it is written as in a URL."""
    return quote(name, safe=" ") if "/" in name or "%" in name else name


def _datasets(h5py: Any, file: Any) -> Iterator[tuple[str, Any]]:
    """Datasets by channel name: those at the root, and those one level down in a group named as a signal."""
    seen: set[str] = set()
    for link in file:
        node = member(h5py, file, link)
        if isinstance(node, h5py.Dataset):
            found = [(_dataset_channel(h5py, node, link), node)]
        elif link in SIGNALS:
            found = [(f"{link}.{joint}", member(h5py, node, joint)) for joint in node]
        else:
            remedy = "groups are named by signals, such as q, and hold one dataset per joint"
            raise InputError("the group is no signal", value=link, remedy=remedy)
        for name, dataset in found:
            if name not in ("t", RESERVED):
                check_name(name)
            check_new(name, seen)
            if not isinstance(dataset, h5py.Dataset):
                raise InputError("the channel is no dataset", remedy="groups nest one deep", channel=name)
            seen.add(name)
            check_count(len(seen))
            yield name, dataset


def _anywhere(h5py: Any, file: Any) -> Iterator[tuple[str, Any]]:
    """Every dataset of a file without our convention, by its path; those with our convention by channel name."""
    groups = [("", file)]
    met = 0
    for path, group in groups:
        for link in group:
            met += 1
            check_count(met)
            if not isinstance(group.get(link, getlink=True), h5py.HardLink):
                continue
            node = group[link]
            if isinstance(node, h5py.Dataset):
                name = (
                    f"{path}.{link}"
                    if path in SIGNALS
                    else f"{path}/{link}"
                    if path
                    else _dataset_channel(h5py, node, link)
                )
                yield name, node
            elif isinstance(node, h5py.Group):
                groups.append((f"{path}/{link}" if path else link, node))


def member(h5py: Any, group: Any, link: str) -> Any:
    """The object of a hard link; soft and external links are refused, because they could lead anywhere.

    Args:
        h5py: the module.
        group: that holds the link.
        link: its name.

    Raises:
        InputError: a soft or an external link.
    """
    if not isinstance(group.get(link, getlink=True), h5py.HardLink):
        raise InputError("a link leads out of the file", value=link, remedy="copy the linked dataset into the file")
    return group[link]


def _dataset_channel(h5py: Any, dataset: Any, link: str) -> str:
    return (attribute(h5py, dataset, "channel") if "%" in link else "") or link


def attribute(h5py: Any, dataset: Any, name: str) -> str | None:
    """An attribute that is one text; empty if there is none, None if it is something else or longer than 999 bytes.

    Args:
        h5py: the module.
        dataset: that has it.
        name: of the attribute.
    """
    if name not in dataset.attrs:
        return ""
    stored = dataset.attrs.get_id(name)
    if not h5py.check_string_dtype(stored.dtype) or stored.shape not in ((), (1,)):
        return None
    text = np.ravel(dataset.attrs[name])[0]
    data = text.encode("utf-8", "surrogateescape") if isinstance(text, str) else bytes(text)
    return data.decode("utf-8", "replace") if len(data) <= _LONGEST_UNIT else None


def check_storage(dataset: Any, name: str) -> None:
    """Refuse a dataset whose bytes are in other files or in chunks of more than 1 GiB.

    Args:
        dataset: that will be read.
        name: for the message.

    Raises:
        InputError: such a dataset.
    """
    if dataset.is_virtual or dataset.external:
        raise InputError("the samples lie in another file", remedy="copy the samples into the file", channel=name)
    if math.prod(dataset.chunks or ()) * dataset.dtype.itemsize > _LARGEST_CHUNK:
        raise InputError("a chunk is larger than 1 GiB", remedy="write smaller chunks", channel=name)


def _dataset_text(h5py: Any, dataset: Any) -> str:
    kind = h5py.check_string_dtype(dataset.dtype)
    if kind is None or not kind.length or dataset.shape != ():
        remedy = "write it with write_recording"
        raise InputError("meta is not one JSON text of fixed length", key=RESERVED, remedy=remedy)
    return bytes(dataset[()]).decode()
