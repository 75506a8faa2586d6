"""Checks of numbers in the user's input."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray


def as_numbers(values: Any) -> NDArray[np.float64]:
    """A new array of doubles; text, dates and complex numbers are refused.

    Raises:
        TypeError, ValueError, OverflowError: the values are no numbers.
    """
    if np.asarray(values).dtype.kind not in "fiubO":
        raise TypeError("not real numbers")
    array = np.array(values, dtype=np.float64)
    if array.ndim > 2:
        raise ValueError("more than two dimensions")
    return array


def as_number(value: Any) -> float:
    """The value as a float; NaN if it is no number (such as text, a truth value or None), inf if it is too large."""
    if isinstance(value, bool | np.bool_) or not isinstance(value, int | float | np.integer | np.floating):
        return math.nan
    try:
        return float(value)
    except OverflowError:  # an integer of hundreds of digits
        return math.inf if value > 0 else -math.inf
