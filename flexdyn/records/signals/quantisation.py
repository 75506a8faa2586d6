"""The step of a quantised channel, and the number of samples for which each value is held."""

from __future__ import annotations

from itertools import chain

import numpy as np

from flexdyn.checks import Array

_FEWEST_LEVELS = 5
_RMS = 0.06
"""Largest rms distance of levels from a grid, in steps; without a grid it is 0.29 [1]."""


def quantisation_step(x: Array) -> float | None:
    """The grid spacing of all samples, or None if there is no grid.

    The smallest distance between different values (or a small integer fraction of it, if levels were skipped) is
    refined by least squares over longer and longer spans. It is a step if every level is then on the grid, within the
    digits of the file: a resolver of 3.815e-4 rad, written with six decimals, is found.

    Args:
        x: samples.

    Returns:
        The step [unit of x]; None for continuous values or fewer than 5 levels.
    """
    values = np.unique(x)
    resolved = 1e-12 * max(float(np.abs(values[[0, -1]]).max()), float(values[-1] - values[0]))
    levels = values[np.concatenate([[True], np.diff(values) > resolved])]
    if len(levels) < _FEWEST_LEVELS:
        return None
    smallest = float(np.diff(levels).min())
    for divisor in range(1, 7):
        step = _refined(levels - levels[0], np.diff(levels), smallest / divisor)
        if step is not None and step > resolved:
            return step
    return None


def _refined(levels: Array, gaps: Array, step: float) -> float | None:
    """The step by least squares from distances of neighbours, then over all; None if they fit no grid."""
    longer = (levels[lag:] - levels[:-lag] for lag in 4 ** np.arange(1, 12) if lag < len(levels))
    for distances in chain([gaps], longer, [levels]):
        counts = np.round(distances / step)
        if np.sqrt(np.mean((distances / step - counts) ** 2)) > _RMS:
            return None
        step = float(np.sum(distances * counts) / np.sum(counts**2))
    return step


def held_for(x: Array) -> int:
    """Number of samples for which each value is held: 1, or more if a slower clock made the values.

    The distances of all changes are multiples of this number; it is 1 if there are fewer than 8 changes.
    """
    changes = np.flatnonzero(np.diff(x) != 0)
    if len(changes) < 8:
        return 1
    return int(np.gcd.reduce(np.diff(changes)))
