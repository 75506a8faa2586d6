"""MATLAB's MAT-file version 5 (``save -v6`` and ``-v7``), read by SciPy.

SciPy recurses in C as deep as a file says and takes types from it without a check. A small hostile file can crash it:
`read_here` is called in another process, see `flexdyn.records.apart`.
"""

from __future__ import annotations

import contextlib
import math
import os
import warnings
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from flexdyn.errors import InputError
from flexdyn.records.bounds import check_size
from flexdyn.records.matlab.columns import MOST_STRUCTS, Leaf, LeafColumns
from flexdyn.records.request import Request
from flexdyn.records.table import Table, damage_named

_VERSION = 1
_ELEMENT = 8
"""Bytes of a number, and of the place of a struct in an array of structs."""


def library() -> Any:
    """The module scipy.io."""
    import scipy.io

    return scipy.io


def read_here(path: Path, request: Request) -> Table:
    """Read the requested columns; variables that have none of them are skipped.

    Args:
        path: of the file.
        request: what is wanted, and how the file is laid out.

    Raises:
        InputError: no MAT-file of version 5, truncated, a variable that is there twice, or too many numbers.
    """
    scipy_io = library()
    columns = LeafColumns(request)
    with damage_named("not a MAT-file, or truncated"):
        major, _ = scipy_io.matlab.matfile_version(path, appendmat=False)
        if major != _VERSION:
            remedy = "save it again in MATLAB with save(..., '-v7')"
            raise InputError("not a MAT-file of version 5 or 7.3", remedy=remedy)
        with contextlib.suppress(TypeError):  # whosmat stops at objects (strings, tables): the process bounds those
            shapes = [shape for name, shape, _ in scipy_io.whosmat(path, appendmat=False) if columns.wants(name)]
            check_size(_ELEMENT * sum(math.prod(map(abs, shape)) for shape in shapes), os.path.getsize(path))
        with warnings.catch_warnings():
            warnings.filterwarnings("error", r'Duplicate variable name "(?!None")')  # objects are called None
            values = scipy_io.loadmat(path, appendmat=False, variable_names=columns.variables())
        names = [name for name in values if not name.startswith("__")]  # the others are SciPy's own
        for place, name in enumerate(names):
            columns.take(_leaves(scipy_io.matlab, name, values.pop(name), 0))
            request.report((place + 1) / len(names))
        return columns.table()


def _leaves(matlab: Any, name: str, value: Any, depth: int) -> Iterator[Leaf]:
    """A variable as SciPy gives it, or the content of its fields."""
    if depth > MOST_STRUCTS:
        raise InputError(f"structs nest deeper than {MOST_STRUCTS}", value=name, remedy="save plainer variables")
    other = _other(matlab, value)
    if other == "a struct array" and value.size == 1:
        for field in value.dtype.names:
            yield from _leaves(matlab, f"{name}.{field}", value.flat[0][field], depth + 1)
    elif other:
        yield Leaf(name, other, (), str)
    elif value.dtype.kind == "U":
        yield Leaf(name, "text", value.shape, lambda: "".join(value.flat))
    else:
        yield Leaf(name, "numbers", value.shape, lambda: value)


def _other(matlab: Any, value: Any) -> str:
    """What it is, if it is neither numbers nor text."""
    if not isinstance(value, np.ndarray):
        return "a sparse array" if hasattr(value, "tocsc") else "an object"
    if isinstance(value, matlab.MatlabFunction):
        return "a function handle"
    if isinstance(value, matlab.MatlabObject | matlab.MatlabOpaque):
        return "an object"
    if value.dtype.names:
        return "a struct array"
    return {"O": "a cell array", "c": "complex numbers"}.get(value.dtype.kind, "")
