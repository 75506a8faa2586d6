"""The filter width with the best compromise between noise and distortion of the motion."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from flexdyn.checks import Array, check_known
from flexdyn.errors import InputError
from flexdyn.records.signals.kernels import DIFFERENCE_REACH, kernels
from flexdyn.records.signals.noise import Noise
from flexdyn.records.signals.noise_spectrum import window_of
from flexdyn.records.signals.smooth import ORDERS, Smoother

_LONGEST_SEGMENT = 8192
_GROWTH = 1.15
NARROWEST_WIDTH = 5
"""Of a smoother of degree 3 [samples]: on fewer the polynomial would pass through all of them."""
_AROUND = 15
"""Number of bins that are averaged before motion is detected: a single bin may exceed the noise by chance."""


def best_smoother(x: npt.ArrayLike, rate: float, noise: Noise, *, order: str = "second") -> Smoother:
    """The smoother with the smallest estimated error of one output.

    Wiener's criterion (1949) over the widths of the family: with the motion's spectrum S (Welch's estimate for the
    samples minus the spectrum N of the noise, where the difference is significant) and the filter's response H,

        error^2(width) = mean over frequency of w^(2 order) ((1 - H)^2 S + H^2 N).

    Motion below the noise at its frequency cannot be seen and is not counted.

    Args:
        x: uniform samples (samples,).
        rate: samples per second [Hz].
        noise: of the channel, as `estimate_noise` finds it.
        order: the output that is to be best: ``"value"``, ``"first"`` or ``"second"``.

    Raises:
        InputError: too few samples.
    """
    check_known(order, ORDERS, "no such output", key="order", value=order)
    samples = np.asarray(x, float)
    narrowest = Smoother(NARROWEST_WIDTH, rate)
    length = min(_LONGEST_SEGMENT, 2 ** int(np.log2(max(1, len(samples) // 3))))
    if length < 4 * narrowest.reach:
        problem, remedy = f"{len(samples)} samples are too few to choose a width", "give the smoother yourself"
        raise InputError(problem, key="x", remedy=remedy)
    motion, noisy = _spectra(samples, noise, length)
    w = 2 * np.pi * np.arange(length // 2 + 1) / length
    weight = w ** (2 * ORDERS[order])
    best, least = narrowest, np.inf
    width = float(narrowest.width)
    while width + 2 * DIFFERENCE_REACH <= length // 2:
        smoother = Smoother(2 * round((width - 1) / 2) + 1, rate)
        response = _response(smoother, length)
        error = float(np.mean(weight * ((1 - response) ** 2 * motion + response**2 * noisy)))
        if error < least:
            best, least = smoother, error
        width *= _GROWTH
    return best


def _response(smoother: Smoother, length: int) -> Array:
    """H at the bins of a segment, by one FFT."""
    kernel = kernels(smoother.width // 2, smoother.degree, smoother.taper).value
    padded = np.zeros(length)
    padded[: len(kernel)] = kernel
    return np.asarray(np.fft.rfft(np.roll(padded, -smoother.reach)).real)


def _spectra(x: Array, noise: Noise, length: int) -> tuple[Array, Array]:
    """Power of motion and noise per bin, both from segments of second differences under Blackman-Harris windows."""
    from scipy.signal import welch

    moved = np.diff(x, 2)
    segments = (len(moved) - length) // (length // 2) + 1
    _, both = welch(moved, window=window_of(length), nperseg=length, detrend=False, return_onesided=False)
    power = both[: length // 2 + 1]
    sine = 2 * np.sin(np.pi * np.arange(length // 2 + 1) / length)
    sine[0] = sine[1]
    total = power / sine**4
    noisy = _noise_power(noise, length)
    around = np.convolve(total, np.full(_AROUND, 1 / _AROUND), "same")
    significant = around > noisy * (1 + 4 / np.sqrt(segments * _AROUND / 3))
    return np.where(significant, total - noisy, 0.0), noisy


def _noise_power(noise: Noise, length: int) -> Array:
    """Power per bin from the autocovariance: constant for white noise, else smoothed by triangular weights."""
    lags = np.array(noise.autocovariance[:1] if noise.white else noise.autocovariance)
    k = np.arange(len(lags))
    weights = np.where(k > 0, 2.0, 1.0) * (1 - k / len(lags)) * lags
    return np.asarray(np.cos(2 * np.pi * np.outer(np.arange(length // 2 + 1), k) / length) @ weights)
