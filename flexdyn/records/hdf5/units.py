"""Units that an HDF5 file holds as text of variable length, read by a process of its own.

Such text lies in a heap that no checksum guards, and HDF5 hangs or crashes on damaged ones (HDFGroup/hdf5 issue 1707).
A process that is given a few seconds can do so without harm; what it cannot say is then not known.
"""

from __future__ import annotations

import json
import subprocess
import sys
from collections.abc import Mapping
from pathlib import Path

TIME_LIMIT = 10.0
"""Seconds that a file's units may take; a sound file takes less than one."""

_READ = """\
import json, sys
path, names, sys.path[:] = json.load(sys.stdin)
try:
    import resource
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    resource.setrlimit(resource.RLIMIT_AS, (2**32, 2**32))
except (ImportError, ValueError, OSError):
    pass
import h5py
with h5py.File(path, "r") as file:
    units = [file[name].attrs["units"] for name in names]
units = [unit.item() if getattr(unit, "size", 0) == 1 else unit for unit in units]
print(json.dumps([unit if isinstance(unit, str) and len(unit) < 1000 else None for unit in units]))
"""


def units_of_variable_length(path: Path, datasets: Mapping[str, str]) -> dict[str, str | None]:
    """The attributes ``units`` of some datasets.

    Args:
        path: of the file.
        datasets: place in the file by the column's name.

    Returns:
        The unit by the column's name; None where it could not be read.
    """
    if not datasets:
        return {}
    task = json.dumps([str(path.resolve()), list(datasets.values()), sys.path])
    # The code stands above and the interpreter is this one: nothing of the file is executed.
    command = [sys.executable, "-I", "-c", _READ]
    try:
        done = subprocess.run(command, input=task, capture_output=True, text=True, timeout=TIME_LIMIT, check=True)  # noqa: S603
        units = json.loads(done.stdout)
    except (OSError, ValueError, subprocess.SubprocessError):
        units = [None] * len(datasets)
    return dict(zip(datasets, units, strict=True))
