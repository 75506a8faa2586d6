"""Roots of many functions at once: every component depends only on its own unknown and does not decrease with it."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from flexdyn.arrays import Array, Flags

Balance = Callable[[Array], Array]
MOST_DOUBLINGS = 100
"""Doublings of the first step after which a component counts as having no root."""


def roots(f: Balance, start: Array, step: Array, tolerance: Array | float) -> tuple[Array, Flags]:
    """Solve f_j(x_j) = 0 for every j together.

    Args:
        f: (n,) -> (n,), component by component, nowhere decreasing.
        start: first guess (n,); kept where abs(f) is within the tolerance.
        step: first step of the search (n,), above 0.
        tolerance: of abs(f); if rounding of x does not allow it, the best x is used.

    Returns:
        The roots (n,), and whether there is one (n,); where there is none, x is the end of the search.
    """
    low, high, f_low, f_high = _brackets(f, start, step, tolerance)
    found = (f_low <= tolerance) & (f_high >= -tolerance)
    for turn in range(400):
        inside = np.spacing(np.maximum(np.abs(low), np.abs(high)))
        open_ = found & (np.abs(f_low) > tolerance) & (np.abs(f_high) > tolerance) & (high - low > inside)
        if not open_.any():
            break
        # False position, and every third time bisection: kinks and flat pieces cannot stop the progress.
        width = np.where(open_, f_high - f_low, 1.0)
        share = np.full_like(low, 0.5) if turn % 3 == 2 else np.clip(-f_low / width, 1e-3, 1.0 - 1e-3)
        middle = np.where(open_, low + share * (high - low), low)
        exact = np.where(open_, low - f_low * (high - low) / width, low)
        if turn % 3 == 0:
            middle = np.where(open_ & (exact > low) & (exact < high), exact, middle)
        value = f(middle)
        left, right = open_ & (value < 0), open_ & (value >= 0)
        low, f_low = np.where(left, middle, low), np.where(left, value, f_low)
        high, f_high = np.where(right, middle, high), np.where(right, value, f_high)
    return np.where(np.abs(f_low) <= np.abs(f_high), low, high), found


def _brackets(f: Balance, start: Array, step: Array, tolerance: Array | float) -> tuple[Array, Array, Array, Array]:
    """Intervals in which every component changes its sign, found by doubling steps from the start."""
    value = f(start)
    low, high, f_low, f_high = start.copy(), start.copy(), value.copy(), value.copy()
    reach = step.copy()
    for _ in range(MOST_DOUBLINGS):
        down, up = f_low > tolerance, f_high < -tolerance
        if not (down.any() or up.any()):
            break
        # One end becomes the other: the root is within the last step.
        high, f_high = np.where(down, low, high), np.where(down, f_low, f_high)
        low, f_low = np.where(up, high, low), np.where(up, f_high, f_low)
        low, high = np.where(down, low - reach, low), np.where(up, high + reach, high)
        f_low, f_high = np.where(down, f(low), f_low), np.where(up, f(high), f_high)
        reach = 2.0 * reach
    return low, high, f_low, f_high
