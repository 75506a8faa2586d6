"""Panels of trajectories: quantiles over all runs, in bounded memory, channel by channel and joint by joint."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from flexdyn.arrays import Array, Indices, evenly
from flexdyn.batch.results import Results
from flexdyn.plots.arrange import Block
from flexdyn.plots.palette import INK, blend, hue
from flexdyn.plots.panel import Curve, Key, Panel, short

_WIDE, _HALF = "9 of 10 runs between", "half of all runs between"
LINES = {
    0.05: (_WIDE, "dashed", 0.9, 0.45),
    0.95: (_WIDE, "dashed", 0.9, 0.45),
    0.25: (_HALF, "solid", 0.9, 0.3),
    0.75: (_HALF, "solid", 0.9, 0.3),
    0.5: ("median", "solid", 1.7, 0.0),
}
"""Share of runs below each line, the lowest line first: label, dash, width [pt] and paleness."""
INSTANTS = 1000
"""Largest number of samples of a trajectory that are drawn."""
MOST_JOINTS_DRAWN = 8
EXACT = 4_000_000
"""Up to so many numbers are kept in memory (32 MB), and quantiles are exact."""
HISTOGRAM_BINS = 512
"""Number of bins for more numbers: the error of a quantile is below the range at its instant over this number."""


def trajectory_keys() -> tuple[Key, ...]:
    """The legend that all panels share."""
    keys = [Key(label, blend(INK, "#FFFFFF", pale), dash, width) for label, dash, width, pale in LINES.values()]
    return tuple(dict.fromkeys(reversed(keys)))


def trajectories(results: Results, channels: Sequence[str], notes: list[str]) -> list[Block]:
    """A row for each joint, a panel for each channel.

    Args:
        results: of the study.
        channels: to be drawn.
        notes: list to which notes about omissions are added.
    """
    times = results.times
    instants = evenly(len(times), INSTANTS)
    joints = results.joints[:MOST_JOINTS_DRAWN]
    if len(joints) < len(results.joints):
        notes.append(f"Trajectories of the first {MOST_JOINTS_DRAWN} of {len(results.joints)} joints.")
    if len(instants) < len(times):
        notes.append(f"Of {len(times)} samples of a trajectory {len(instants)} are drawn.")
    panels = {channel: _panels(results, channel, instants) for channel in channels}
    rows = tuple(tuple(panels[channel][j] for channel in channels) for j in range(len(joints)))
    rows = tuple(tuple(replace(panel, labelled=j == len(joints) - 1) for panel in row) for j, row in enumerate(rows))
    width = {1: 6.3, 2: 4.6}.get(len(channels), 3.5)
    return [Block(rows, (1.8,) * len(rows), width)]


def _panels(results: Results, channel: str, instants: Indices) -> list[Panel]:
    found = quantiles(lambda: results.blocks(channel, instants), len(results.complete), tuple(LINES))
    t, unit = results.times[instants], results.unit(channel)
    return [_panel(t, found[:, :, j], f"{channel}.{joint}", unit, hue(j)) for j, joint in enumerate(results.joints)]


def _panel(t: Array, lines: Array, name: str, unit: str, colour: str) -> Panel:
    curves = tuple(
        Curve(t, line, f"{name}, {share:.0%}", label, blend(colour, "#FFFFFF", pale), dash, width)
        for line, (share, (label, dash, width, pale)) in zip(lines, LINES.items(), strict=True)
    )
    signal, _, joint = name.partition(".")
    label, span = f"{signal} [{unit}]", (float(t[0]), float(t[-1]))
    return Panel.over_time(short(joint), label, curves, span, colour=colour)


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
        place = np.minimum(((block - low) / width * HISTOGRAM_BINS).astype(np.int64), HISTOGRAM_BINS - 1)
        counts += np.bincount((place.reshape(len(block), -1) + start).ravel(), minlength=len(counts))
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
