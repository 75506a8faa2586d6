"""Checks of numbers and words in the user's input."""

from __future__ import annotations

import math
from collections.abc import Collection, Hashable
from typing import Any

import numpy as np

from flexdyn.arrays import Array as Array
from flexdyn.errors import InputError, did_you_mean


def as_numbers(key: str, values: Any, problem: str = "numbers are needed", remedy: str | None = None) -> Array:
    """A new array of doubles, of two dimensions at most; text, dates and complex numbers are refused.

    Args:
        key: its path, for the error.
        values: as given.
        problem: the fault that is reported.
        remedy: what the user can do.

    Raises:
        InputError: the values are no numbers.
    """
    try:
        plain = np.asarray(values).dtype.kind in "fiubO"
        array = np.array(values, dtype=np.float64) if plain else None
    except (TypeError, ValueError, OverflowError):
        array = None
    if array is None or array.ndim > 2:
        raise InputError(problem, key=key, value=values, remedy=remedy)
    return array


def as_number(value: Any) -> float:
    """The value as a float; NaN if it is no number (such as text, a truth value or None), inf if it is too large."""
    if isinstance(value, bool | np.bool_) or not isinstance(value, int | float | np.integer | np.floating):
        return math.nan
    try:
        return float(value)
    except OverflowError:  # an integer of hundreds of digits
        return math.inf if value > 0 else -math.inf


def number(
    key: str,
    value: Any,
    problem: str = "a finite number is needed",
    *,
    least: float = -math.inf,
    above: float = -math.inf,
    infinite: bool = False,
    remedy: str | None = None,
) -> float:
    """Check a number of the user's input.

    Args:
        key: its path, for the error.
        value: as given.
        problem: the fault that is reported.
        least: smallest allowed value.
        above: a value below all allowed ones.
        infinite: whether it may be inf.
        remedy: what the user can do.

    Raises:
        InputError: it is no such number.
    """
    found = as_number(value)
    finite = math.isfinite(found) or (infinite and found == math.inf)
    if not finite or found < least or (found <= above and above > -math.inf):
        raise InputError(problem, key=key, value=value, remedy=remedy)
    return found


def whole(
    key: str, value: Any, least: int, most: float = math.inf, *, problem: str = "", remedy: str | None = None
) -> int:
    """Check a whole number of the user's input; truth values are none.

    Args:
        key: its path, for the error.
        value: as given.
        least: smallest allowed value.
        most: largest allowed value.
        problem: the fault that is reported; default: the smallest value that is needed.
        remedy: what the user can do.

    Raises:
        InputError: it is no such number.
    """
    if isinstance(value, bool) or not isinstance(value, int | np.integer) or not least <= value <= most:
        raise InputError(
            problem or f"a whole number of at least {least} is needed", key=key, value=value, remedy=remedy
        )
    return int(value)


def check_known(word: Any, known: Collection[str], problem: str, **where: Any) -> None:
    """Refuse a word that is none of the known ones; unless a remedy is given, it names the most similar one.

    Args:
        word: the given word.
        known: accepted words.
        problem: the fault, in a few words.
        where: further arguments of `InputError`: file, key, value, channel, remedy.

    Raises:
        InputError: it is another word.
    """
    if not isinstance(word, Hashable) or word not in known:
        raise InputError(problem, **({"remedy": did_you_mean(str(word), known)} | where))
