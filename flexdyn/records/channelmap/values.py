"""Single values of a channel map, checked."""

from __future__ import annotations

import math
from collections.abc import Collection
from typing import Any

from flexdyn.checks import as_number
from flexdyn.errors import InputError, did_you_mean

POSITIVE = ("gear_ratio", "torque_constant", "counts_per_turn", "full_counts")
"""Numbers that a reversed sign would be hidden in: they have none."""


def as_choice(key: str, value: Any, known: Collection[str]) -> str:
    """One of a few words.

    Raises:
        InputError: another.
    """
    if not isinstance(value, str) or value not in known:
        raise InputError("no such choice", key=key, value=value, remedy=did_you_mean(str(value), known))
    return value


def as_source(key: str, value: Any) -> str | int:
    """A column by name or number.

    Raises:
        InputError: neither.
    """
    if isinstance(value, int) and not isinstance(value, bool) and value >= 1:
        return value
    if not isinstance(value, str) or not value:
        raise InputError("the name of a column, or its number from 1, is needed", key=key, value=value)
    return value


def as_text(key: str, value: Any) -> str:
    """A text that is not blank.

    Raises:
        InputError: something else.
    """
    if not isinstance(value, str) or not value.strip():
        raise InputError("a text is needed", key=key, value=value)
    return value


def as_finite(key: str, name: str, value: Any, *, positive: bool = False) -> float:
    """A finite number; some are never zero, some always above it.

    Args:
        key: of the mapping that it stands in.
        name: its key there.
        value: as given.
        positive: whether it must be above zero, as those of `POSITIVE` must.

    Raises:
        InputError: it is not.
    """
    number = as_number(value)
    if not math.isfinite(number):
        raise InputError("a finite number is needed", key=f"{key}.{name}", value=value)
    if (positive or name in POSITIVE) and number <= 0:
        remedy = "a reversed channel has sign: -1" if name in POSITIVE else None
        raise InputError("a number above zero is needed", key=f"{key}.{name}", value=value, remedy=remedy)
    if name in ("factor", "full_scale") and number == 0:
        raise InputError("a number other than zero is needed", key=f"{key}.{name}", value=value)
    return number
