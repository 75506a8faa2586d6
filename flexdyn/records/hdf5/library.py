"""h5py, and a new HDF5 file that does not crash on a full disk."""

from __future__ import annotations

import io
from collections.abc import Iterator
from contextlib import closing, contextmanager
from pathlib import Path
from typing import Any

from flexdyn.errors import needed


def library() -> Any:
    """The module h5py."""
    with needed("h5py", "hdf5"):
        import h5py
    return h5py


@contextmanager
def new_file(path: Path, **settings: Any) -> Iterator[Any]:
    """A new file to write to, in a layout that HDF5 1.10 reads.

    Args:
        path: of the file, which must not exist.
        settings: further arguments of `h5py.File`.

    Raises:
        OSError: the disk is full, or cannot be written to.
        MissingExtra: h5py is not installed.
    """
    h5py = library()
    with closing(_Target(path)) as target:
        with h5py.File(target, "w", track_order=True, libver=("v110", "v110"), **settings) as file:
            yield file
        if target.refusal is not None:
            raise target.refusal


class _Target:
    """A file whose writes never fail; if the disk cannot be written to, this is noted, and the data go into memory.

    HDF5 crashes the process, immediately or later, if it cannot close a file because the disk is full (h5py issue 914).
    """

    def __init__(self, path: Path) -> None:
        self._at: io.FileIO | io.BytesIO = open(path, "x+b", buffering=0)  # noqa: SIM115 - `new_file` closes it
        self.refusal: OSError | None = None

    def __getattr__(self, name: str) -> Any:
        """Everything that only reads is that of the file."""
        return getattr(self._at, name)

    def write(self, data: Any) -> int:
        """Write all bytes; from an error of the disk on, into memory."""
        left = memoryview(data).cast("B")
        while left:
            try:
                left = left[self._at.write(left) or 0 :]
            except OSError as error:
                self._go_on_in_memory(error)
        return memoryview(data).nbytes

    def truncate(self, size: int) -> int:
        """Set the length of the file [bytes]; where the disk refuses, go on in memory."""
        try:
            return self._at.truncate(size)
        except OSError as error:
            self._go_on_in_memory(error)
            return size

    def _go_on_in_memory(self, refusal: OSError) -> None:
        """Read from the present position of the file."""
        self.refusal = refusal
        place = self._at.tell()
        self._at.seek(0)
        memory = io.BytesIO(self._at.read() or b"")
        self._at.close()
        memory.seek(place)
        self._at = memory
