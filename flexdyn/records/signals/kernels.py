"""Weights of the smoothing filters: local polynomials with exact differences of them, and Gaussians.

`Smoother`, for users, uses the local polynomials; `GaussianSmoother` is that of the diagnosis.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from flexdyn.arrays import Array
from flexdyn.io.locked import lock

DIFFERENCE_REACH = 4
"""Additional samples on each side that the differences need."""

_SQUARED = np.array([1.0, -2.0, 1.0])
_CENTRAL = np.array([-0.5, 0.0, 0.5])
_FIRST_SERIES = (1.0, -1 / 6, 1 / 30, -1 / 140)
_SECOND_SERIES = (1.0, -1 / 12, 1 / 90, -1 / 560)
KERNEL_REACH = 5.0
"""Half length of a kernel in standard deviations [1]: the neglected part is below 1e-6."""


@dataclass(frozen=True, eq=False)
class Kernels:
    """Weights by offset from -reach to reach, per sample and per sample squared; read-only.

    Attributes:
        value: smooths; sums to 1 exactly.
        first: smoothed first derivative; antisymmetric, sums to 0 exactly.
        second: smoothed second derivative; symmetric, sums to 0 exactly.
        held: smooths a signal that is held from each sample to the next; sums to 1 exactly.
    """

    value: Array
    first: Array
    second: Array
    held: Array


def correlated(x: Array, kernel: Array) -> Array:
    """sum_m kernel[half + m] x[k + m] of a column or table x, where the kernel (2 half + 1,) is within the samples."""
    from scipy.ndimage import correlate1d  # here, as `import flexdyn` loads no scipy

    half = len(kernel) // 2
    return np.asarray(correlate1d(x, kernel, axis=0)[half : len(x) - half])


@lru_cache(maxsize=256)
def kernels(half: int, degree: int, taper: int) -> Kernels:
    """The four kernels of one smoother.

    The value is that of the polynomial of `degree`, fitted with the weights (1 - (j/(half + 1))^2)^taper, at the
    centre. Derivatives are differences of it, exact on polynomials up to degree 8 (Fornberg 1988): with d the central
    difference and m the mean of two neighbours,

        first  = m d (1 - d^2/6 + d^4/30 - d^6/140) value
        second = d^2 (1 - d^2/12 + d^4/90 - d^6/560) value
        held   = (x_k + x_(k-1))/2 (1 - d^2/12 + d^4/90 - d^6/560) value

    so that one frequency response H multiplies every term: H, i w H, -w^2 H. If x'' = u with u held between samples,
    then x_(k+1) - 2 x_k + x_(k-1) = (u_k + u_(k-1))/2 exactly, and therefore second(x) = held(u) without error.

    Args:
        half: samples on each side of the fit.
        degree: of the polynomial.
        taper: exponent of the weights; 0 gives Savitzky and Golay's smoothing weights.

    Returns:
        The kernels, cached.
    """
    fit = _fit(half, degree, taper)
    corrected = np.convolve(fit, _series(_SECOND_SERIES))
    value = np.pad(_symmetric(fit, total=1.0), DIFFERENCE_REACH)
    first = np.convolve(np.convolve(fit, _series(_FIRST_SERIES)), _CENTRAL)
    first = (first - first[::-1]) / 2
    second = _symmetric(np.convolve(corrected, _SQUARED), total=0.0)
    smooth = _symmetric(corrected, total=1.0) / 2
    held = np.pad(smooth, (0, 2)) + np.pad(smooth, (1, 1))
    return Kernels(*(lock(kernel) for kernel in (value, first, second, _summing_to_one(held))))


def _fit(half: int, degree: int, taper: int) -> Array:
    """Weights of the fitted polynomial's value at the centre; odd powers vanish there by symmetry."""
    u = np.arange(-half, half + 1) / (half + 1)
    root = (1 - u**2) ** (taper / 2)
    powers = np.polynomial.legendre.legvander(u, degree)[:, ::2]
    basis, triangle = np.linalg.qr(root[:, None] * powers)
    centre = np.linalg.solve(triangle.T, powers[half])
    weights = root * (basis @ centre)
    return np.asarray((weights + weights[::-1]) / 2)


def _series(terms: tuple[float, ...]) -> Array:
    """The sum of terms[i] d^(2 i) as weights, symmetric."""
    total, power = np.zeros(2 * len(terms) - 1), np.ones(1)
    for term in terms:
        total += term * np.pad(power, (len(total) - len(power)) // 2)
        power = np.convolve(power, _SQUARED)
    return total


def _symmetric(kernel: Array, total: float) -> Array:
    """The kernel, rounded to a grid with exact sums; its centre is chosen so that the sum is exactly `total`."""
    half = len(kernel) // 2
    side = _rounded(kernel[:half], kernel)
    return np.concatenate([side, [total - 2 * side.sum()], side[::-1]])


def _summing_to_one(kernel: Array) -> Array:
    rounded = _rounded(kernel, kernel)
    rounded[len(kernel) // 2] += 1.0 - rounded.sum()
    return rounded


def _rounded(part: Array, kernel: Array) -> Array:
    """Multiples of a power of two that is so large that no sum over the kernel needs rounding."""
    grid = 2.0 ** (math.frexp(float(np.abs(kernel).sum()))[1] - 52)
    return np.asarray(np.round(part / grid) * grid)


@dataclass(frozen=True, eq=False)
class GaussianSmoother:
    """A Gaussian smoother and its first two derivatives, sampled.

    ``y_k(t) = sum_m taps[k, m] x(t + m dt)``. Derivative taps sum to zero and reproduce straight lines and parabolas
    exactly, so that a position has no influence on a velocity and a velocity none on an acceleration.

    `Smoother`, for users, finds its width from the data and reproduces cubics. The smallest error of its second
    derivative is below that of a Gaussian of any width, on smooth motion by a factor of 3 to 11
    (`tests/records/test_smooth.py`). The diagnosis needs something else: the same few milliseconds in every recording,
    positive weights, so that a smoothed signal never overshoots at the corners that friction makes, and variances that
    add where one filter follows another. docs/noise_and_smoothing.md has what both were measured at.

    Attributes:
        taps: (3, 2 half + 1) [1, 1/s, 1/s^2].
    """

    taps: Array

    @classmethod
    def of_width(cls, sigma: float, dt: float) -> GaussianSmoother:
        """The smoother of standard deviation `sigma` [s] at the sample time `dt` [s]."""
        width = sigma / dt
        half = max(4, math.ceil(KERNEL_REACH * width))
        m = np.arange(-half, half + 1.0)
        weight = np.exp(-0.5 * (m / width) ** 2)
        value = weight / weight.sum()
        first = m * weight
        first /= m @ first
        second = (m * m - m @ (m * weight) / weight.sum()) * weight
        second -= second.sum() * value
        second *= 2.0 / ((m * m) @ second)
        return cls(np.array([value, first / dt, second / dt**2]))

    @property
    def variance(self) -> float:
        """Variance of the Gaussian, as sampled [samples^2]."""
        m = np.arange(-self.half, self.half + 1)
        return float(self.taps[0] @ m**2)

    @property
    def half(self) -> int:
        """Samples lost at either end."""
        return int(self.taps.shape[1]) // 2

    def apply(self, x: Array, order: int) -> Array:
        """The smoothed derivative of that order (samples - 2 half, ...) of x (samples, ...)."""
        return correlated(x, self.taps[order])
