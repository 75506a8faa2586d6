"""Smooth and differentiate samples with one zero-phase filter, the same for every term of an equation."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from flexdyn.checks import Array, as_number, check_known, number, whole
from flexdyn.errors import InputError
from flexdyn.records.signals.kernels import DIFFERENCE_REACH, Kernels, correlated, kernels

ORDERS: Mapping[str, int] = {"value": 0, "first": 1, "second": 2, "held": 0}
"""Outputs of a smoother, and how often each is differentiated."""

_LONG_KERNEL = 300
_WIDEST = 100_001
_FINE = 4096


@dataclass(frozen=True)
class Smoother:
    """A local polynomial filter on uniform samples: value, first and second derivative with the same low-pass.

    The value at sample k is that of the polynomial of `degree`, fitted to the `width` samples around k with the weights
    (1 - (j/(half + 1))^2)^taper (Savitzky & Golay 1964 for taper 0; the taper lowers the side lobes). The derivatives
    are differences of the same filter, so that every term of an equation of motion is multiplied by the same frequency
    response H: value H, first i w H, second -w^2 H. Savitzky and Golay's own derivatives have another response for each
    order and would cause a residual in an exact equation.

    Polynomials up to `degree` are reproduced exactly. Samples that the kernel does not cover are dropped: outputs are
    shorter by ``2 * reach`` and belong to the times ``t[smoother.valid]``.

    Args:
        width: number of samples of the fit, odd, at least 2*(degree//2) + 3, the narrowest that smooths.
        rate: samples per second [Hz].
        degree: of the polynomial, 1 to 7; an even degree equals the next odd one.
        taper: exponent of the weights, 0 to 8.

    Raises:
        InputError: outside these limits.

    Example:
        >>> smoother = fd.Smoother.at_cutoff(20.0, 1000.0)  # Hz, of samples at 1 kHz
        >>> t = np.arange(2000) / 1000
        >>> smoother.first(np.sin(t)).size < t.size
        True
    """

    width: int
    rate: float
    degree: int = 3
    taper: int = 3

    def __post_init__(self) -> None:
        """Refuse arguments outside the limits."""
        _in_range("degree", self.degree, 1, 7)
        _in_range("taper", self.taper, 0, 8)
        _in_range("width", self.width, self._least(self.degree), _WIDEST)
        if self.width % 2 == 0:
            remedy = f"give {self.width - 1} or {self.width + 1}"
            raise InputError("the width is even: no sample is its centre", key="width", value=self.width, remedy=remedy)
        sample_rate(self.rate)

    @classmethod
    def at_cutoff(cls, cutoff: float, rate: float, degree: int = 3, taper: int = 3) -> Smoother:
        """The filter whose cut-off, with the response 1/sqrt(2), is nearest to a frequency.

        Args:
            cutoff: [Hz].
            rate: samples per second [Hz].
            degree: of the polynomial.
            taper: exponent of the weights.

        Raises:
            InputError: no filter of this degree has that cut-off at that rate.
        """
        narrowest = cls(cls._least(degree), rate, degree, taper)
        wanted = as_number(cutoff)
        if not 0 < wanted <= narrowest.cutoff:
            remedy = f"give more than 0 and at most {narrowest.cutoff:.4g} Hz"
            raise InputError("no such cut-off at this rate and degree", key="cutoff", value=cutoff, remedy=remedy)
        width = cls._least(degree) * narrowest.cutoff / wanted
        for _ in range(3):  # the cut-off is only nearly proportional to 1/width
            now = cls(cls._odd(width, degree), rate, degree, taper)
            width = now.width * now.cutoff / wanted
        near = (cls(cls._odd(width + step, degree), rate, degree, taper) for step in (-2, 0, 2))
        return min(near, key=lambda smoother: abs(smoother.cutoff - wanted))

    @staticmethod
    def _least(degree: int) -> int:
        """The narrowest odd width that smooths: with fewer samples the polynomial would pass through all of them."""
        return 2 * (degree // 2) + 3

    @classmethod
    def _odd(cls, width: float, degree: int) -> int:
        return max(cls._least(degree), 2 * round((min(width, _WIDEST) - 1) / 2) + 1)

    @property
    def reach(self) -> int:
        """Samples lost at each end."""
        return self.width // 2 + DIFFERENCE_REACH

    @property
    def valid(self) -> slice:
        """The samples of the input to which the outputs belong: ``t[smoother.valid]``."""
        return slice(self.reach, -self.reach)

    @property
    def cutoff(self) -> float:
        """Frequency at which the response has fallen to 1/sqrt(2) (-3 dB) [Hz]."""
        kernel = self._kernels.value
        points = 2 ** math.ceil(math.log2(max(_FINE, 32 * len(kernel))))
        size = np.abs(np.fft.rfft(kernel, points))
        below = np.flatnonzero(size < math.sqrt(0.5))
        if not len(below):
            return self.rate / 2
        right = int(below[0])
        share = (size[right - 1] - math.sqrt(0.5)) / (size[right - 1] - size[right])
        return float((right - 1 + share) * self.rate / points)

    def response(self, frequency: npt.ArrayLike) -> Array:
        """The frequency response H(f), by which the amplitude of a sine is multiplied; it is real: no phase shift.

        Args:
            frequency: [Hz], any shape.
        """
        w = 2 * np.pi * np.asarray(frequency, float) / self.rate
        side = self._kernels.value[self.reach :]
        total = np.full(w.shape, side[0])
        for j in np.flatnonzero(side[1:]) + 1:
            total += 2 * side[j] * np.cos(j * w)
        return np.asarray(total)

    def value(self, x: npt.ArrayLike) -> Array:
        """Smoothed samples at `valid`, for signals that are sampled (q, v, tau_s)."""
        return self._applied(x, "value")

    def first(self, x: npt.ArrayLike) -> Array:
        """Smoothed first derivative at `valid` [unit of x per second]; exactly 0 for a constant."""
        return self._applied(x, "first")

    def second(self, x: npt.ArrayLike) -> Array:
        """Smoothed second derivative at `valid` [unit of x per second squared]; exactly 0 for a constant."""
        return self._applied(x, "second")

    def held(self, x: npt.ArrayLike) -> Array:
        """Smoothed samples at `valid` of a signal that is held from each sample to the next (tau, tau_applied).

        If the acceleration of x is a held u, then ``second(x) == held(u)``, up to rounding.
        """
        return self._applied(x, "held")

    def noise_std(self, order: str, autocovariance: npt.ArrayLike) -> float:
        """Standard deviation of an output if the input is stationary noise with any autocovariance.

        Args:
            order: ``"value"``, ``"first"``, ``"second"`` or ``"held"``.
            autocovariance: of the input at lags 0, 1, 2, ... samples; zero beyond those given: [1.0] is white noise of
                standard deviation 1.
        """
        check_known(order, ORDERS, "no such output", key="order", value=order)
        kernel: Array = getattr(self._kernels, order)
        given = np.asarray(autocovariance, float)[: len(kernel)]
        both = np.correlate(kernel, kernel, "full")[len(kernel) - 1 :][: len(given)]
        variance = 2 * float(given @ both) - float(given[0] * both[0])
        return math.sqrt(max(0.0, variance)) * float(self.rate) ** ORDERS[order]

    @property
    def _kernels(self) -> Kernels:
        return kernels(int(self.width) // 2, int(self.degree), int(self.taper))

    def _applied(self, x: npt.ArrayLike, order: str) -> Array:
        """Correlate columns with a kernel; the first sample is subtracted, so that constants are exact."""
        kernel, power, samples = getattr(self._kernels, order), ORDERS[order], np.asarray(x, float)
        self._check(samples)
        start = samples[:1]
        moved = samples - start
        if len(kernel) > _LONG_KERNEL:
            from scipy.signal import oaconvolve

            columns = kernel[::-1] if samples.ndim == 1 else kernel[::-1, None]
            out = oaconvolve(moved, columns, mode="valid", axes=0)
        else:
            out = correlated(moved, kernel)
        return np.asarray(out * self.rate**power if power else out + start)

    def _check(self, samples: Array) -> None:
        """Refuse samples of a wrong shape, too few, or with gaps."""
        if samples.ndim not in (1, 2):
            remedy = "give (samples,) or (samples, channels)"
            raise InputError("the samples are no column or table", key="x", value=samples.shape, remedy=remedy)
        if len(samples) <= 2 * self.reach:
            problem = f"{len(samples)} samples, and the filter of width {self.width} needs {2 * self.reach + 1}"
            raise InputError(problem, key="x", remedy="give more samples or a smaller width")
        finite = np.isfinite(samples)
        if not finite.all():
            row = int(np.argmin(finite.reshape(len(samples), -1).all(axis=1)))
            raise InputError(f"row {row}: not a finite number", key="x", remedy="remove or fill the gap", row=row)


def _in_range(key: str, value: object, least: int, most: int) -> None:
    whole(key, value, least, most, problem="not a whole number in range", remedy=f"give {least} to {most}")


def sample_rate(rate: Any) -> float:
    """Check a sample rate [Hz].

    Raises:
        InputError: it is not above 0 and finite.
    """
    return number("rate", rate, "not a sample rate", above=0.0, remedy="give samples per second [Hz]")
