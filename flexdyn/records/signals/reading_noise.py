"""The noise of single readings: what changes from sample to sample, without a spectrum and without memory."""

from __future__ import annotations

import numpy as np

from flexdyn.checks import Array

GAUSS = 1.4826
"""Standard deviation over median absolute deviation of a Gaussian."""
_SIXTH_DIFFERENCE = np.array([1.0, -6.0, 15.0, -20.0, 15.0, -6.0, 1.0])
_ON_A_GRID, _OFF_THE_GRID = 0.99, 0.01
"""Share of all changes that are whole steps of a quantised channel, and how far from whole they may be [steps]."""


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
    high = np.convolve(x, _SIXTH_DIFFERENCE, "valid") / np.linalg.norm(_SIXTH_DIFFERENCE)
    changes = np.convolve(np.abs(np.diff(x)), np.ones(len(_SIXTH_DIFFERENCE) - 1), "valid") > 0.0
    return robust_std(high[changes]) if changes.any() else 0.0


def reading_noise(x: Array) -> float:
    """Standard deviation of one reading of an encoder, by which the diagnosis weighs it [unit of x].

    It is the larger one of `high_frequency_std` and, if the readings are whole steps, step/sqrt(12).

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
    counted = np.mean(np.abs(ratio - np.round(ratio)) < _OFF_THE_GRID) > _ON_A_GRID
    return max(float(step / np.sqrt(12.0)) if counted else 0.0, high_frequency_std(x))
