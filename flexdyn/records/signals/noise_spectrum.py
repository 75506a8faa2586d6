"""Contrasts that remove any smooth motion, and the spectrum of the noise that is left in them."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from flexdyn.arrays import Array, Flags, Indices
from flexdyn.records.signals.reading_noise import GAUSS

SEGMENT_LENGTHS = (256, 128, 64, 32, 16)
_FEWEST_SEGMENTS = 24
_CLIP = 4.0
_STEEP = 25.0
"""If the power exceeds that an octave above by this factor (14 dB), the spectrum is that of the motion [1]."""
_TOP = 0.85
"""Bins above this share of the band are combined: drives that average two readings have a zero at its end [1]."""


@dataclass(frozen=True, eq=False)
class Spectrum:
    """Noise power by frequency, of one channel.

    Attributes:
        power: mean square per bin of k/(2 (len - 1)) cycles per sample; their mean (ends by half) is the variance.
        seen: first bin in which the noise is larger than the motion; bins below are extrapolated.
    """

    power: Array
    seen: int

    @property
    def flatness(self) -> float:
        """Geometric over arithmetic mean of the seen bins: 1 for white noise, less for coloured noise."""
        power = self.power[self.seen :]
        return float(np.exp(np.mean(np.log(power))) / np.mean(power))

    @property
    def autocovariance(self) -> Array:
        """Autocovariance at lags 0, 1, ... samples."""
        return np.asarray(np.fft.irfft(self.power)[: len(self.power)])


def contrasts(t: Array, x: Array, order: int) -> Array:
    """Weighted sums of order + 1 neighbours that are zero for every polynomial below that order, at any times.

    Divided differences, c_i = 1/prod_(j != i) (t_i - t_j), scaled to unit length (Czesla et al. 2018): white noise
    keeps its standard deviation in them. On uniform times they are the differences of that order over sqrt(C(2p, p)).

    Args:
        t: times (samples,) [s].
        x: samples.
        order: p.

    Returns:
        (samples - order,).
    """
    count = len(x) - order
    scaled = (t - t[0]) / float(np.median(np.diff(t)))
    weights = np.ones((order + 1, count))
    for i in range(order + 1):
        for j in range(order + 1):
            if i != j:
                weights[i] /= scaled[i : i + count] - scaled[j : j + count]
    total = np.zeros(count)
    for i in range(order + 1):
        total += weights[i] * (x[i : i + count] - x[:count])
    return np.asarray(total / np.sqrt(np.sum(weights**2, axis=0)))


def clipped(values: Array, moves: Flags) -> tuple[float, Flags]:
    """Standard deviation of the bulk, and a mask of the values that belong to it.

    Kinks of the motion (reversals, breakaway, shocks) and spikes differ from the bulk by more than 4 of its standard
    deviations. They and two neighbours on either side are left out, repeatedly until nothing changes.

    Args:
        values: contrasts.
        moves: mask of the contrasts in which the channel changes.

    Returns:
        Standard deviation and mask.
    """
    if not moves.any():
        return 0.0, moves
    size = np.abs(values)
    std, good = GAUSS * float(np.median(size[moves])), moves
    for _ in range(20):
        bad = np.convolve(size > _CLIP * std, np.ones(5), "same") > 0.5
        now = moves & ~bad
        if not now.any() or (now == good).all():
            break
        good, std = now, float(np.sqrt(np.mean(values[now] ** 2)))
    return std, good


def spectrum(values: Array, good: Flags, order: int) -> Spectrum | None:
    """Noise spectrum from the contrasts of that order, over segments in which nothing was left out.

    Windows suppress leakage by 92 dB; the mean power of the segments (Welch
    1967) is divided by the result for white noise, near |2 sin(w/2)|^(2 p)/C(2p, p).

    Args:
        values: contrasts of uniform (or nearly uniform) samples.
        good: mask of the contrasts to use.
        order: p.

    Returns:
        The spectrum, or None where too few segments are free of kinks.
    """
    for length in SEGMENT_LENGTHS:
        starts = _segments(good, length)
        if len(starts) >= _FEWEST_SEGMENTS:
            break
    else:
        return None
    window = window_of(length)
    pieces = values[starts[:, None] + np.arange(length)] * window
    power = np.mean(np.abs(np.fft.rfft(pieces)) ** 2, axis=0)
    return _above_motion(power / _of_white_noise(window, order))


def window_of(length: int) -> Array:
    """The four-term window of Blackman and Harris (1978), with side lobes at -92 dB.

    SciPy's window is sampled at the ends of the intervals; every second value of one twice as long is at their middles.
    """
    from scipy.signal.windows import blackmanharris  # here, as `import flexdyn` loads no scipy

    return np.asarray(blackmanharris(2 * length + 1)[1::2])


def _of_white_noise(window: Array, order: int) -> Array:
    """White noise of variance 1 in each bin: the transform of the autocorrelations of window times contrasts.

    The autocorrelation of the contrasts is (-1)^l C(2p, p + l)/C(2p, p). Dividing by the response at the bin alone
    would neglect the width of the window, an error of 7 % at order 4.
    """
    length = len(window)
    both = np.correlate(window, window, "full")[length - 1 :]
    lags = np.arange(order + 1)
    weights = np.array([(-1) ** lag * math.comb(2 * order, order + lag) for lag in lags]) / math.comb(2 * order, order)
    phase = 2 * np.pi * np.outer(np.arange(length // 2 + 1), lags) / length
    twice = np.where(lags > 0, 2.0, 1.0)
    return np.asarray(np.cos(phase) @ (twice * weights * both[: order + 1]))


def _segments(good: Flags, length: int) -> Indices:
    """Starts of half-overlapping segments without masked values."""
    starts = np.arange(0, len(good) - length + 1, length // 2)
    total = np.concatenate([[0], np.cumsum(good)])
    return np.asarray(starts[total[starts + length] - total[starts] == length])


def _above_motion(power: Array) -> Spectrum:
    """The noise alone: from the highest frequency down to where the motion dominates, extrapolated below."""
    last = len(power) - 1
    top = int(_TOP * last)
    bins = np.arange(5, top + 1)
    above = np.array([np.max(power[min(2 * int(k), top) : min(2 * int(k) + 2, last) + 1]) for k in bins])
    steep = bins[power[bins] > _STEEP * above]
    seen = min(math.ceil(1.5 * int(steep.max())), last - 2) if len(steep) else 5
    noise = power.copy()
    noise[:seen] = np.mean(power[seen : max(seen + 3, min(2 * seen, last))])
    noise.setflags(write=False)
    return Spectrum(noise, seen)
