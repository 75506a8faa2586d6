"""Single readings: their quantisation, how long each is held, and the noise that changes from sample to sample."""

from __future__ import annotations

from itertools import chain

import numpy as np

from flexdyn.arrays import Array

_FEWEST_LEVELS = 5
_RMS = 0.06
"""Largest rms distance of levels from a grid, in steps; without a grid it is 0.29 [1]."""
GAUSS = 1.4826
"""Standard deviation over median absolute deviation of a Gaussian."""
_SIXTH_DIFFERENCE = np.array([1.0, -6.0, 15.0, -20.0, 15.0, -6.0, 1.0])
_FAR_OFF = 3.0
"""Standard deviations from which a difference is no noise [1]."""
_ON_A_GRID, _OFF_THE_GRID = 0.99, 0.01
"""Share of all changes that are whole steps of a quantised channel, and how far from whole they may be [steps]."""


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
    return 1 if len(changes) < 8 else int(np.gcd.reduce(np.diff(changes)))


def robust_std(values: Array) -> float:
    """Standard deviation of the bulk of the values: 1.4826 times their median absolute deviation."""
    return GAUSS * float(np.median(np.abs(values - np.median(values))))


def high_frequency_std(x: Array) -> float:
    """Standard deviation of the white noise that has the sixth differences of these uniform samples.

    Sixth differences hardly contain any motion. Of noise with memory they contain the part that changes from sample to
    sample. While a quantised channel stays on one value it hides its noise: such samples are left out.

    Returns:
        The standard deviation; 0 if nothing changes.
    """
    high = _sixth_differences(x)
    return robust_std(high) if len(high) else 0.0


def _sixth_differences(x: Array) -> Array:
    """Sixth differences where a sample changes, as large as the noise of one sample (differences,)."""
    high = np.convolve(x, _SIXTH_DIFFERENCE, "valid") / np.linalg.norm(_SIXTH_DIFFERENCE)
    changes = np.convolve(np.abs(np.diff(x)), np.ones(len(_SIXTH_DIFFERENCE) - 1), "valid") > 0.0
    return np.asarray(high[changes])


def reading_noise(x: Array) -> float:
    """Standard deviation of one reading of an encoder, by which the diagnosis weighs it [unit of x].

    If the readings are whole steps, it is the root mean square of their sixth differences without what is far off, or
    step/sqrt(12) if that is larger: sixth differences of steps are whole numbers, and the median of a few of them is up
    to 1.7 times too large. Else it is `high_frequency_std`.

    Args:
        x: uniform samples (samples,).

    Returns:
        The standard deviation; 0 if nothing changes.
    """
    steps = np.abs(np.diff(x))
    moved = steps[steps > 0.0]
    if not len(moved):
        return 0.0
    step = float(moved.min())
    ratio = moved / step
    if not np.mean(np.abs(ratio - np.round(ratio)) < _OFF_THE_GRID) > _ON_A_GRID:
        return high_frequency_std(x)
    high, rounding = _sixth_differences(x), float(step / np.sqrt(12.0))
    bulk = np.abs(high) <= _FAR_OFF * max(robust_std(high), rounding)
    return max(rounding, float(np.sqrt(np.mean(high[bulk] ** 2)))) if bulk.any() else rounding
