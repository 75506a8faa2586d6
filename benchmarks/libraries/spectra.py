"""Spectra of noise: windows and Welch's method of `scipy.signal`, and what our own code did or does.

The window and the plain mean over segments are the library's; the formulas that stood in their place are here, as the
other side of the comparison. Noise is estimated over segments without kinks of the motion, which `welch` cannot choose.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from pathlib import Path

import numpy as np
from comparison import Case, Comparison, outcome, times_of
from numpy.typing import NDArray
from scipy.signal import welch

from flexdyn.records.signals.noise_spectrum import clipped, contrasts, spectrum, window_of

Array = NDArray[np.float64]
LENGTH, ORDER, RATE, SAMPLES = 256, 4, 1000.0, 60_000


def compare(data: Path) -> list[Comparison]:
    """The window, Welch's method over all segments, and over those that are chosen.

    Args:
        data: folder of the measured data.
    """
    t, noise = np.arange(SAMPLES) / RATE, np.random.default_rng(0).standard_normal(SAMPLES)
    return [_windows(), _all_segments(noise), _chosen_segments(t, noise)]


def _windows() -> Comparison:
    x = np.random.default_rng(1).standard_normal(SAMPLES)
    library, ours = (partial(_mean, x, window) for window in (window_of, _formula))
    cases = [Case("Blackman and Harris", "", outcome(lambda: bool(np.allclose(window_of(LENGTH), _formula(LENGTH)))))]
    times = {f"in a spectrum of {SAMPLES:,} samples": times_of(library, ours)}
    about = "SciPy, scipy.signal.windows.blackmanharris"
    return Comparison("windows", "a formula of four cosines", about, cases, times)


def _formula(length: int) -> Array:
    phase = 2 * np.pi * (np.arange(length) + 0.5) / length
    return np.asarray(0.35875 - 0.48829 * np.cos(phase) + 0.14128 * np.cos(2 * phase) - 0.01168 * np.cos(3 * phase))


def _all_segments(x: Array) -> Comparison:
    library, ours = partial(_welch, x), partial(_mean, x, window_of)
    cases = [Case("white noise", "", outcome(lambda: bool(np.allclose(library(), ours(), rtol=1e-12))))]
    times = {f"{SAMPLES:,} samples": times_of(library, ours)}
    return Comparison("Welch's method", "a mean of NumPy's transforms", "SciPy, scipy.signal.welch", cases, times)


def _welch(x: Array) -> Array:
    settings = {"nperseg": LENGTH, "noverlap": LENGTH // 2, "detrend": False, "return_onesided": False}
    return np.asarray(welch(x, window=window_of(LENGTH), **settings)[1])


def _mean(x: Array, window_of_length: Callable[[int], Array]) -> Array:
    window = window_of_length(LENGTH)
    starts = range(0, len(x) - LENGTH + 1, LENGTH // 2)
    power = np.mean([np.abs(np.fft.fft(x[k : k + LENGTH] * window)) ** 2 for k in starts], axis=0)
    return np.asarray(power / np.sum(window**2))


def _chosen_segments(t: Array, noise: Array) -> Comparison:
    """Noise of 1e-4 rad on a joint at rest, and on one that turns back twice a second without slowing down before."""
    size, path = 1e-4, 5.0 * np.abs((2.0 * t) % 2.0 - 1.0)
    cases = []
    for what, x in (("a joint at rest", size * noise), ("a joint that turns back twice a second", path + size * noise)):
        values = contrasts(t, x, ORDER)
        _, good = clipped(values, np.ones(len(values), bool))
        cases.append(Case(what, _told(values, good, size), _told(values, np.ones_like(good), size)))
    ours = "flexdyn.records.signals.noise_spectrum"
    return Comparison("the spectrum of noise beside motion", ours, "SciPy, scipy.signal.welch", cases, {})


def _told(values: Array, chosen: NDArray[np.bool_], size: float) -> str:
    """How far off the noise is that the mean over the chosen segments gives; over all of them it is Welch's."""
    found = spectrum(values, chosen, ORDER)
    std = np.nan if found is None else float(np.sqrt(found.autocovariance[0]))
    return "" if abs(std / size - 1.0) < 0.1 else f"{std / size:.1f} times the noise"
