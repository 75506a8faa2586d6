"""Quantiles of trajectories over any number of runs, in bounded memory."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence

import numpy as np
from numpy.typing import NDArray

from flexdyn.checks import Array

EXACT = 4_000_000
"""Up to so many numbers are kept in memory (32 MB), and quantiles are exact."""
HISTOGRAM_BINS = 512
"""Number of bins for more numbers: the error of a quantile is below the range at its instant over this number."""


def quantiles(blocks: Callable[[], Iterator[Array]], runs: int, shares: Sequence[float]) -> Array:
    """Quantiles over runs of arrays of one shape.

    Args:
        blocks: yields the runs in blocks (some, ...), without NaN; it is called twice.
        runs: number of runs.
        shares: of runs below each quantile, 0 to 1.

    Returns:
        The quantiles (shares, ...); NaN if there are no runs.
    """
    first = next(blocks(), None)
    if first is None:
        return np.full((len(shares), 1), np.nan)
    if runs * first[0].size <= EXACT:
        return np.asarray(np.quantile(np.concatenate(list(blocks())), shares, axis=0))
    low, high = first.min(axis=0), first.max(axis=0)
    for block in blocks():
        np.minimum(low, block.min(axis=0), out=low)
        np.maximum(high, block.max(axis=0), out=high)
    return _of_histogram(_histogram(blocks(), low, high), low, high, shares)


def _histogram(blocks: Iterator[Array], low: Array, high: Array) -> NDArray[np.int64]:
    """The number of runs in each of the bins between smallest and largest value (..., bins)."""
    counts = np.zeros(low.size * HISTOGRAM_BINS, dtype=np.int64)
    start = np.arange(low.size) * HISTOGRAM_BINS
    width = np.where(high > low, high - low, 1.0)
    for block in blocks:
        place = np.minimum(((block - low) / width * HISTOGRAM_BINS).astype(np.int64), HISTOGRAM_BINS - 1).reshape(
            len(block), -1
        )
        counts += np.bincount((place + start).ravel(), minlength=len(counts))
    return counts.reshape(*low.shape, HISTOGRAM_BINS)


def _of_histogram(counts: NDArray[np.int64], low: Array, high: Array, shares: Sequence[float]) -> Array:
    """The values at which the cumulative histogram reaches each share, interpolated linearly within a bin."""
    below = np.cumsum(counts, axis=-1)
    found = np.empty((len(shares), *low.shape))
    for i, share in enumerate(shares):
        wanted = share * below[..., -1:]
        bin = np.minimum((below < wanted).sum(axis=-1), HISTOGRAM_BINS - 1)
        here = np.take_along_axis(counts, bin[..., None], axis=-1)[..., 0]
        before = np.take_along_axis(below, bin[..., None], axis=-1)[..., 0] - here
        part = np.clip((wanted[..., 0] - before) / np.maximum(here, 1), 0.0, 1.0)
        found[i] = low + (bin + part) / HISTOGRAM_BINS * (high - low)
    return found
