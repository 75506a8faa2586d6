"""Frozen dataclasses whose arrays and mappings nobody can change."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import fields
from functools import partial
from types import MappingProxyType
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

Kept = TypeVar("Kept")


class Locked:
    """Base of a frozen dataclass: its arrays and mappings are read-only, also after it was pickled."""

    def __post_init__(self) -> None:
        """Lock every array and mapping."""
        for name, value in _entries(self).items():
            object.__setattr__(self, name, lock(value))

    def __reduce__(self) -> tuple[Any, ...]:
        """Unpickle through the constructor, which locks again; read-only mappings do not pickle."""
        return (partial(type(self), **{name: plain(value) for name, value in _entries(self).items()}), ())


def lock(value: Kept) -> Kept:
    """The value with arrays made read-only, those of tuples and mappings too, and a mapping as a read-only copy."""
    if isinstance(value, np.ndarray):
        value.setflags(write=False)
    elif isinstance(value, tuple):
        for entry in value:
            lock(entry)
    elif isinstance(value, Mapping):
        return MappingProxyType({key: lock(entry) for key, entry in value.items()})  # type: ignore[return-value]
    return value


def locked_copy(values: Any, dtype: Any = np.float64) -> NDArray[Any]:
    """A copy of an array that nobody can write to.

    Args:
        values: of the array.
        dtype: of its entries.
    """
    return lock(np.array(values, dtype=dtype, order="C"))


def plain(value: Any) -> Any:
    """The value with read-only mappings as plain ones, which pickle."""
    return {key: plain(entry) for key, entry in value.items()} if isinstance(value, Mapping) else value


def frozen(value: Any) -> Any:
    """A deep copy of plain data that cannot change: read-only mappings, tuples, numbers."""
    if isinstance(value, Mapping):
        return MappingProxyType({str(key): frozen(entry) for key, entry in value.items()})
    if isinstance(value, np.ndarray | np.generic):
        value = value.tolist()
    return tuple(frozen(entry) for entry in value) if isinstance(value, list | tuple) else value


def thawed(value: Any) -> Any:
    """A deep copy of such data in dictionaries and lists, as YAML and JSON have them."""
    if isinstance(value, Mapping):
        return {key: thawed(entry) for key, entry in value.items()}
    return [thawed(entry) for entry in value] if isinstance(value, tuple | list) else value


def _entries(of: Any) -> dict[str, Any]:
    return {entry.name: getattr(of, entry.name) for entry in fields(of)}
