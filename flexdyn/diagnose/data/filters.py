"""The two filters that every term of an equation passes, and the rate of the rows."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from flexdyn import _core
from flexdyn.arrays import Array, Indices
from flexdyn.records.signals.kernels import GaussianSmoother

FIRST_FILTER_WIDTH = 0.00125
"""Standard deviation of the first filter [s]: as small as the clock allows, because it rounds corners of the motion."""
SECOND_FILTER_WIDTHS = (0.005, 0.008, 0.0128, 0.02)
"""Standard deviations of the second filter [s]: the narrowest that leaves the encoders' noise below the torque's."""


@dataclass(frozen=True)
class Filters:
    """The two filters that every term passes, and the rate of the rows.

    Attributes:
        first: smooths the measured signals; laws are evaluated after it.
        second: smooths every term of an equation in the same way.
        every: number of samples for each row.
    """

    first: GaussianSmoother
    second: GaussianSmoother
    every: int

    @classmethod
    def of_rate(cls, dt: float, first: float = FIRST_FILTER_WIDTH, second: float = SECOND_FILTER_WIDTHS[0]) -> Filters:
        """Filters with these standard deviations [s]; wider ones if the clock is too slow for them."""
        narrow = max(first, 1.25 * dt)
        wide = max(second, 2.5 * dt)
        first_filter, second_filter = (GaussianSmoother.of_width(width, dt) for width in (narrow, wide))
        return cls(first_filter, second_filter, max(1, round(2.0 * wide / dt)))

    def rows(self, x: Array, order: int = 0) -> Array:
        """The second filter's derivative of that order of x (samples, ...), one row of every `every` samples."""
        table = np.ascontiguousarray(x.reshape(len(x), -1), dtype=float)
        y = np.empty((self.count(len(x)), table.shape[1]))
        _core.filter_rows(table, self.second.taps[order], self.every, y)
        return y.reshape(-1, *x.shape[1:])

    def calmed(self, x: Array) -> Array:
        """A signal (samples, ...) through the second filter at every sample; its first and last values hold beyond."""
        from scipy.ndimage import convolve1d

        return np.asarray(convolve1d(x, self.second.taps[0], axis=0, mode="nearest"))

    def count(self, samples: int) -> int:
        """Number of rows for a number of samples after the first filter."""
        return max(0, (samples - 2 * self.second.half - 1) // self.every + 1)

    def reach(self, passes: int) -> int:
        """Samples to either side that count in a row, after so many passes of the first filter.

        Three standard deviations of each filter.
        """
        return round(0.6 * (passes * self.first.half + self.second.half))

    def instants(self, samples: int) -> Indices:
        """Samples after the first filter to which the rows belong."""
        return self.second.half + self.every * np.arange(self.count(samples))


def later(t: Array, x: Array, by: float) -> Array:
    """A smooth signal later by a time, by cubic splines; its first and last values hold beyond.

    Straight lines between the samples would smooth it once more, and its noise.

    Args:
        t: times of its samples [s].
        x: the signal (samples,).
        by: the time; negative: earlier [s].
    """
    from scipy.interpolate import CubicSpline

    return np.asarray(CubicSpline(t, x)(np.clip(t - by, t[0], t[-1])))
