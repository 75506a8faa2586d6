"""Single values of a channel map, checked."""

from __future__ import annotations

from collections.abc import Collection
from typing import Any

from flexdyn.checks import number
from flexdyn.errors import InputError, check_known

POSITIVE = ("gear_ratio", "torque_constant", "counts_per_turn", "full_counts")
"""Numbers that must be positive, because a negative one would hide a reversed sign."""


def as_choice(key: str, value: Any, known: Collection[str]) -> str:
    """Check that a value is one of the allowed words.

    Raises:
        InputError: it is another one.
    """
    check_known(value, known, "no such choice", key=key, value=value)
    return str(value)


def as_source(key: str, value: Any) -> str | int:
    """Check a column, given by name or number.

    Raises:
        InputError: it is neither.
    """
    if isinstance(value, int) and not isinstance(value, bool) and value >= 1:
        return value
    if not isinstance(value, str) or not value:
        raise InputError("the name of a column, or its number from 1, is needed", key=key, value=value)
    return value


def as_text(key: str, value: Any) -> str:
    """Check for a text that is not blank.

    Raises:
        InputError: it is something else.
    """
    if not isinstance(value, str) or not value.strip():
        raise InputError("a text is needed", key=key, value=value)
    return value


def as_finite(key: str, name: str, value: Any, *, positive: bool = False) -> float:
    """Check a finite number; some must not be zero, some must be above zero.

    Args:
        key: path of the mapping that contains it.
        name: its key there.
        value: as given.
        positive: whether it must be above zero, as those of `POSITIVE` must.

    Raises:
        InputError: it is not.
    """
    key = f"{key}.{name}"
    found = number(key, value)
    if positive or name in POSITIVE:
        remedy = "a reversed channel has sign: -1" if name in POSITIVE else None
        return number(key, value, "a number above zero is needed", above=0.0, remedy=remedy)
    if name in ("factor", "full_scale") and found == 0:
        raise InputError("a number other than zero is needed", key=key, value=value)
    return found
