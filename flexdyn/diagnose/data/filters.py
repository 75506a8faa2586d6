"""The two filters that every term of an equation passes, and the rate of the rows that are kept."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from flexdyn.diagnose.data.kernel import Kernel

Array = NDArray[np.float64]
FIRST_FILTER_WIDTH = 0.00125
"""Standard deviation of the first filter [s]: as narrow as the clock allows, for it rounds corners of the motion."""
SECOND_FILTER_WIDTHS = (0.005, 0.008, 0.0128, 0.02)
"""Standard deviations of the second filter [s]: the narrowest that leaves the encoders' noise below the torque's."""


@dataclass(frozen=True)
class Filters:
    """The two filters that every term passes, and the rate of the rows.

    Attributes:
        first: smooths what is measured; laws are evaluated behind it.
        second: smooths every term of an equation alike.
        every: one row is kept of so many samples.
    """

    first: Kernel
    second: Kernel
    every: int

    @classmethod
    def of_rate(cls, dt: float, first: float = FIRST_FILTER_WIDTH, second: float = SECOND_FILTER_WIDTHS[0]) -> Filters:
        """Filters of these standard deviations [s]; wider ones where the clock is too slow for them."""
        narrow = max(first, 1.25 * dt)
        wide = max(second, 2.5 * dt)
        return cls(Kernel.gaussian(narrow, dt), Kernel.gaussian(wide, dt), max(1, round(2.0 * wide / dt)))

    def rows(self, x: Array, order: int = 0) -> Array:
        """The second filter's derivative of that order of x (samples, ...), one row of every `every` samples."""
        from scipy.signal import upfirdn

        first = 2 * self.second.half  # of the full convolution: the kernel lies within the samples
        shift = -first % self.every
        padded = np.concatenate([np.zeros((shift, *x.shape[1:])), x])
        y = upfirdn(self.second.taps[order][::-1], padded, down=self.every, axis=0)
        return np.asarray(y[(first + shift) // self.every :][: self.count(len(x))])

    def count(self, samples: int) -> int:
        """Rows that so many samples behind the first filter make."""
        return max(0, (samples - 2 * self.second.half - 1) // self.every + 1)

    def instants(self, samples: int) -> NDArray[np.intp]:
        """Samples behind the first filter that the rows stand at."""
        return self.second.half + self.every * np.arange(self.count(samples))
