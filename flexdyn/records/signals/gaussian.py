"""The Gaussian smoother of the diagnosis: short kernels for a fixed time scale.

`Smoother`, for users, finds its width from the data and reproduces cubics. The smallest error of its second derivative
is below that of a Gaussian of any width, on smooth motion by a factor of 3 to 11 (`tests/records/test_smooth.py`). The
diagnosis needs something else: the same few milliseconds in every recording, and positive weights, so that a smoothed
signal never overshoots at the corners that friction makes. Hence two families; `kernels` has what they share.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from flexdyn.checks import Array
from flexdyn.records.signals.kernels import correlated

KERNEL_REACH = 5.0
"""Half length of a kernel in standard deviations [1]: the neglected part is below 1e-6."""


@dataclass(frozen=True, eq=False)
class GaussianSmoother:
    """A Gaussian smoother and its first two derivatives, sampled.

    ``y_k(t) = sum_m taps[k, m] x(t + m dt)``. Derivative taps sum to zero and reproduce straight lines and parabolas
    exactly, so that a position has no influence on a velocity and a velocity none on an acceleration.

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
    def half(self) -> int:
        """Samples lost at either end."""
        return int(self.taps.shape[1]) // 2

    def apply(self, x: Array, order: int) -> Array:
        """The smoothed derivative of that order (samples - 2 half, ...) of x (samples, ...)."""
        return correlated(x, self.taps[order])
