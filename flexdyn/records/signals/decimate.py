"""A recording at a lower rate, after an anti-aliasing filter."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from flexdyn.arrays import Array, Indices
from flexdyn.checks import whole
from flexdyn.errors import InputError
from flexdyn.records.signals.cut import made
from flexdyn.records.signals.gaps import gap_rows
from flexdyn.records.units import is_held

if TYPE_CHECKING:
    from flexdyn.records.recording import Recording

FILTER_REACH = 20
"""Reach of the filter to either side, in samples of the new rate."""
CLOCK_JITTER = 0.02
"""Share of a sample by which stamps may differ from a uniform clock [1]."""


def decimated(rec: Recording, factor: int) -> Recording:
    """Keep one of every `factor` samples, after filtering.

    Sampled signals pass a symmetric FIR filter (`scipy.signal.firwin`, Hamming window, half amplitude at half of the
    new rate, as in `scipy.signal.decimate` but twice as steep). It causes no delay and prevents aliasing. Held signals
    are averaged over the samples that become one, which keeps their impulse. At either end 20 of the new samples, which
    the filter does not cover, are dropped.

    Args:
        rec: the recording, of a uniform clock.
        factor: number of samples that become one, 1 or more.

    Raises:
        InputError: no such factor, gaps, a clock that is not uniform, or too few samples.
    """
    whole("factor", factor, 1, problem="a whole number of samples is needed")
    if factor == 1:
        return rec
    if len(gap_rows(rec.t)):
        raise InputError("there are gaps in time", key="t", remedy="take the pieces between them: rec.split(gaps=...)")
    uniform_rate(rec)
    kept = np.arange(FILTER_REACH * factor, len(rec) - FILTER_REACH * factor, factor)
    kept = kept[kept + factor <= len(rec)]
    if len(kept) < 2:
        problem = f"{len(rec)} samples are too few for a filter over {2 * FILTER_REACH * factor + 1}"
        raise InputError(problem, key="factor", value=factor, remedy="give a smaller one")
    columns = {"t": rec.t[kept]}
    for name, values in rec.channels.items():
        columns[name] = _means_of_group(values, kept, factor) if is_held(name) else _low_pass(values, kept, factor)
    return made(rec, columns)


def _low_pass(values: Array, kept: Indices, factor: int) -> Array:
    from scipy.signal import firwin, resample_poly

    taps = firwin(2 * FILTER_REACH * factor + 1, 1.0 / factor, window="hamming")
    level = values[0]  # subtracted, so that small motions far from zero keep their digits
    low = resample_poly(values - level, 1, factor, window=taps, padtype="line")
    return np.asarray(low[kept // factor] + level)


def _means_of_group(values: Array, kept: Indices, factor: int) -> Array:
    return np.asarray(values[kept[:, None] + np.arange(factor)].mean(axis=1))


def uniform_rate(rec: Recording) -> float:
    """The rate of a recording whose samples are on a uniform grid, within a fiftieth of its period [Hz].

    Raises:
        InputError: they are not; the message gives row and remedy.
    """
    rate = rec.rate
    off = np.abs((rec.t - rec.t[0]) * rate - np.arange(len(rec)))
    if off.max() > CLOCK_JITTER:
        row = int(np.argmax(np.abs(np.diff(rec.t) * rate - 1))) + 1
        typical = 1 / float(np.median(np.diff(rec.t)))
        problem = f"row {row}: the samples are not uniform, {float(off.max()):.2g} periods off a grid"
        remedy = f"resample first: .resample(rate={typical:.4g})"
        raise InputError(problem, value=float(rec.t[row]), remedy=remedy, row=row, channel="t")
    return rate
