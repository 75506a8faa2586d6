"""Numba's compiler with its cache kept out of the source tree."""

from __future__ import annotations

import hashlib
import importlib
import os
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any, TypeVar

Function = TypeVar("Function", bound=Callable[..., Any])


def _cache() -> str:
    """A folder per version of the sources: Numba does not see that a function called by a cached one has changed."""
    text = b"".join(
        file.read_bytes()
        for name in ("two_link_*.py", "layout.py", "cables.py")
        for file in sorted(Path(__file__).parent.glob(name))
    )
    version = hashlib.sha256(text).hexdigest()[:12]
    return str(Path(tempfile.gettempdir()) / f"discovery-numba-{os.getuid()}" / version)


os.environ.setdefault("NUMBA_CACHE_DIR", _cache())


def compiled(function: Function) -> Function:
    """Compile on first use, and keep the machine code for the next process."""
    numba: Any = importlib.import_module("numba")
    machine: Function = numba.njit(cache=True, error_model="numpy")(function)
    return machine
