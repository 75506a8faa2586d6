"""h5py, and a new file of it."""

from __future__ import annotations

import os
import re
from collections.abc import Iterator
from contextlib import contextmanager
from importlib.util import find_spec
from pathlib import Path
from typing import Any

from flexdyn.errors import MissingExtra

_NUMBER = re.compile(r"\berrno = (\d+)")


def check_library() -> None:
    """Refuse where h5py is not installed, without loading it.

    Raises:
        MissingExtra: it is not there.
    """
    if find_spec("h5py") is None:
        raise MissingExtra("h5py", "hdf5")


def library() -> Any:
    """The module h5py."""
    try:
        import h5py
    except ImportError:
        raise MissingExtra("h5py", "hdf5") from None
    return h5py


@contextmanager
def new_file(path: Path, **settings: Any) -> Iterator[Any]:
    """A new file to write to, in a layout that HDF5 1.10 reads.

    Args:
        path: of the file, which must not be there.
        settings: more of them for `h5py.File`.

    Raises:
        OSError: a full disk and the like, in the system's own words.
        MissingExtra: h5py is not installed.
    """
    try:
        with library().File(path, "x", track_order=True, libver=("v110", "v110"), **settings) as file:
            yield file
    except (OSError, RuntimeError) as error:
        # HDF5 tells it on several lines, and h5py as a RuntimeError where the file cannot even be closed.
        found = _NUMBER.search(str(error))
        if found is None:
            raise
        number = int(found[1])
        raise OSError(number, os.strerror(number)) from None
