"""A user's own metric: found by its import path, called, and checked to be one number."""

from __future__ import annotations

import importlib
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from importlib.machinery import PathFinder
from pathlib import Path
from threading import Lock
from typing import Any

import numpy as np

from flexdyn.errors import InputError

_importing = Lock()


def own_function(name: str, folder: Path | None = None) -> Callable[[Any], Any]:
    """The function that an import path names.

    Args:
        name: ``package.module:function``.
        folder: where it is searched first; None: only in Python's own paths.

    Raises:
        InputError: it cannot be imported or is not callable; the message says why.
    """
    module, _, attribute = name.partition(":")
    if not attribute.isidentifier() or not all(part.isidentifier() for part in module.split(".")):
        raise InputError("no such metric", value=name, remedy="your own function is package.module:function")
    with _importing, _first_in_path(module, folder):
        try:
            found = importlib.import_module(module)
        except Exception as error:  # a user's module may raise anything
            reason = f"{type(error).__name__}: {error}" if not isinstance(error, ModuleNotFoundError) else str(error)
            where = f"; it is looked for in {folder} first" if folder is not None else ""
            raise InputError(f"the metric cannot be imported ({reason}){where}", value=name) from None
    function = getattr(found, attribute, None)
    if function is None:
        raise InputError(f"module {module} has no {attribute}", value=name)
    if not callable(function):
        raise InputError("the metric is not callable", value=name, remedy="it is a function of a Run")
    return function  # type: ignore[no-any-return]


def single_number(value: Any) -> float:
    """A metric's answer as one number; true and false are 1 and 0.

    Raises:
        ValueError: it is none.
    """
    array = np.asarray(value)
    if array.shape != () or array.dtype.kind not in "biuf":
        shape = f"an array of shape {array.shape}" if array.shape else f"a {type(value).__name__}"
        raise ValueError(f"one number is needed, not {shape}")
    return float(array)


@contextmanager
def _first_in_path(module: str, folder: Path | None) -> Iterator[None]:
    """Let Python search a folder first; a module of the same name from another place is refused.

    Raises:
        InputError: such a module is loaded already.
    """
    if folder is None:
        yield
        return
    top = module.partition(".")[0]
    place = str(folder.resolve())
    importlib.invalidate_caches()
    spec = PathFinder.find_spec(top, [place])
    loaded = getattr(sys.modules.get(top), "__file__", None)
    if spec is not None and spec.origin is not None and loaded is not None and not _same(spec.origin, loaded):
        remedy = "rename the file, or start Python anew"
        raise InputError(f"another module {top} is loaded already, from {loaded}", value=module, remedy=remedy)
    sys.path.insert(0, place)
    try:
        yield
    finally:
        sys.path.remove(place)


def _same(one: str, other: str) -> bool:
    return Path(one).resolve() == Path(other).resolve()
