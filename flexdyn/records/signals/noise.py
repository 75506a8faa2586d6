"""The noise of a channel, estimated from its samples alone while the arm moves."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from flexdyn.arrays import Array
from flexdyn.errors import InputError
from flexdyn.records.signals.noise_spectrum import Spectrum, clipped, contrasts, spectrum
from flexdyn.records.signals.reading_noise import held_for, quantisation_step, reading_noise
from flexdyn.records.table import Rows, check_finite, check_time

FEWEST = 64
"""Smallest number of samples for an estimate."""

_ORDERS = (4, 8)
_WHITE = 0.85
_CORRELATED = 0.2
_LAGS = 9


@dataclass(frozen=True)
class Noise:
    """Noise of one channel.

    Attributes:
        std: standard deviation of one sample [unit], quantisation included; 0 if the channel is exact.
        unit: of the channel.
        step: quantisation step [unit]; None if the values are on no grid.
        hold: number of samples for which every value is held; 1 if each is new.
        flatness: of the spectrum, geometric over arithmetic mean: 1 is white; None if too few segments are free of
            kinks.
        autocorrelation: at lags 0, 1, ... 8 (times `hold`) samples.
        seen_above: frequency above which the noise is larger than the motion [Hz]; below it, the spectrum is
            extrapolated.
        reading_std: noise that changes from sample to sample [unit], by which the diagnosis weighs encoders
            (`reading_noise`); as `std` for white noise, smaller for noise with memory; None if not estimated.

    Example:
        >>> t = np.arange(4000) / 1000
        >>> q = np.sin(t) + np.random.default_rng(1).normal(0.0, 1e-4, t.size)
        >>> 0.9e-4 < fd.Recording(t, {"q.elbow": q}).noise("q.elbow").std < 1.1e-4
        True
    """

    std: float
    unit: str = ""
    step: float | None = None
    hold: int = 1
    flatness: float | None = None
    autocorrelation: tuple[float, ...] = (1.0,)
    seen_above: float | None = None
    reading_std: float | None = None

    @property
    def exact(self) -> bool:
        """Whether there is no noise, as in a commanded, constant or computed channel."""
        return self.std == 0.0

    @property
    def white(self) -> bool:
        """Whether errors of the samples seem independent: flatness of at least 0.85, no correlation above 0.2."""
        correlated = max((abs(value) for value in self.autocorrelation[1:]), default=0.0)
        return self.flatness is None or (self.flatness >= _WHITE and correlated <= _CORRELATED)

    @property
    def autocovariance(self) -> tuple[float, ...]:
        """Autocovariance [unit^2] at lags 0, 1, ..., the input of `Smoother.noise_std`."""
        return tuple(self.std**2 * value for value in self.autocorrelation)


def estimate_noise(t: npt.ArrayLike, x: npt.ArrayLike, *, unit: str = "", held: bool = False) -> Noise:
    """Estimate the noise of one channel from its own samples.

    Contrasts of order 4 (of order 8 if the motion is fast for the sample rate) remove the motion, and kinks at
    reversals are clipped. The spectrum of the rest, divided by the response of the contrasts, is the spectrum of the
    noise. Below the frequency at which the motion dominates (the spectrum rises by 14 dB within an octave) it is
    continued with its value there. Hence

        std^2 = mean of the noise power over all frequencies, and not less than step^2/12,

    because an encoder that moves less than a step per sample has errors of a whole step although jumps are rare.

    Limits: noise below the frequencies of the motion is not seen (drift, an eccentric encoder). If a controller feeds
    back a noisy sensor, the commanded torque seems to have noise. Jitter of the clock appears as noise of moving
    channels. The error for white noise is within 10 % from about a thousand samples on. Kinks of friction that are too
    small to be clipped, several per second at 250 Hz, raise the estimate by up to a half.

    Args:
        t: times (samples,) [s], increasing, uniform or with jitter.
        x: samples (samples,) [unit].
        unit: of x, copied to the result.
        held: whether x is a command that is held from sample to sample: if values repeat, bit for bit, it is exact.

    Returns:
        The noise.

    Raises:
        InputError: fewer than 64 samples (16 values, if they are held), not finite, time that does not increase.

    Example:
        >>> t = np.arange(4000) / 1000
        >>> q = np.sin(t) + np.random.default_rng(1).normal(0.0, 1e-4, t.size)
        >>> 0.9e-4 < fd.estimate_noise(t, q).std < 1.1e-4
        True
    """
    times, samples = _checked(t, x)
    reading = reading_noise(samples)
    hold = held_for(samples)
    if held and (hold > 1 or np.mean(np.diff(samples) == 0) > 0.5):
        return Noise(0.0, unit, hold=hold, reading_std=reading)
    if hold > 1:
        start = int(np.flatnonzero(np.diff(samples))[0] + 1) % hold
        times, samples = times[start::hold], samples[start::hold]
    if len(samples) < 2 * max(_ORDERS):
        problem = f"{len(samples)} values, each held for {hold} samples, are too few to estimate noise"
        raise InputError(problem, key="x", remedy="give a longer recording")
    step = quantisation_step(samples)
    std, found = _estimated(times, samples, step)
    std = max(std, step / math.sqrt(12) if step else 0.0)
    if std <= 8 * np.finfo(float).eps * float(np.abs(samples).max()):
        return Noise(0.0, unit, step, hold, reading_std=reading)
    if found is None:
        return Noise(std, unit, step, hold, reading_std=reading)
    covariance = found.autocovariance[:_LAGS]
    rate = 1 / float(np.median(np.diff(times)))
    seen = found.seen * rate / (2 * (len(found.power) - 1))
    lags = tuple(float(value) for value in covariance / covariance[0])
    return Noise(std, unit, step, hold, found.flatness, lags, seen, reading)


def _estimated(t: Array, x: Array, step: float | None) -> tuple[float, Spectrum | None]:
    """Standard deviation and spectrum by the lowest order of contrasts that removes the motion."""
    results = []
    for order in _ORDERS:
        values = contrasts(t, x, order)
        changes = np.concatenate([[0], np.cumsum(np.diff(x) != 0)])
        moving = changes[order:] > changes[:-order] if step else np.ones(len(values), np.bool_)
        std, good = clipped(values, moving)
        results.append((std, values, good, order))
    low, high = results
    std, values, good, order = low if low[0] <= 1.5 * high[0] else high
    found = spectrum(values, good, order) if std > 0 else None
    return (std if found is None else math.sqrt(float(found.autocovariance[0]))), found


def _checked(t: npt.ArrayLike, x: npt.ArrayLike) -> tuple[Array, Array]:
    """Times and samples of one channel; refuses too few, gaps and time that does not increase."""
    times, samples = np.asarray(t, float), np.asarray(x, float)
    if times.ndim != 1 or samples.shape != times.shape:
        problem = f"times {times.shape} and samples {samples.shape} are no two columns of one length"
        raise InputError(problem, key="x", remedy="give one channel")
    if len(times) < FEWEST:
        problem = f"{len(times)} samples are too few to estimate noise"
        raise InputError(problem, key="x", remedy=f"give {FEWEST} or more")
    check_time(times, Rows())
    check_finite(samples, "x", Rows())
    return times, samples
