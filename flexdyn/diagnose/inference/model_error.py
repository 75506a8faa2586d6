"""Model error of every equation: its size and its correlation length.

The rows are whitened by the sensors' noise, so that their variance is 1 if the model is right. The residual of a wrong
model is larger, and it is not noise: it repeats with the state. Correlated rows are no independent evidence. Of N rows
with autocorrelations rho_k,

    N/t,    t = 1 + 2 sum_k (1 - k/N) rho_k^2

are independent (Bartlett, 1935). The sum is over all lags of the recording, because a repeated motion says nothing new
about a model error. For every lag with N - k pairs, 1/(N - k) is subtracted from rho_k^2, the expected value for white
rows. For correlated rows it would be t/(N - k), so that t may be estimated as up to 3 t - 2: evidence is counted too
low rather than too high.

Rows of a mean square v below 1 have less noise than they are taken to have. What is missing counts as white noise:
their autocorrelations are v rho_k.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from flexdyn.arrays import Array, Flags


@dataclass(frozen=True, eq=False)
class Seen:
    """Which rows of the equations say something.

    Attributes:
        valid: (rows of an equation, equations).
        lengths: rows of an equation in each recording.
    """

    valid: Flags
    lengths: tuple[int, ...]

    @property
    def count(self) -> Array:
        """Rows that say something (equations,)."""
        return np.asarray(np.maximum(self.valid.sum(axis=0).astype(float), 1.0))


@dataclass(frozen=True, eq=False)
class ModelError:
    """Size and memory of what is left at each equation.

    Attributes:
        scale: root mean square of the rows, at least the sensors' noise (equations,) [1].
        times: rows that say one thing, at least one (equations,).
        count: rows that say something (equations,).
    """

    scale: Array
    times: Array
    count: Array

    @classmethod
    def of(cls, left: Array, seen: Seen, *, about_mean: bool = False) -> ModelError:
        """Of what a structure leaves (rows of all equations,).

        Args:
            left: rows of all equations (rows,).
            seen: which of them say something.
            about_mean: take the memory of what varies about the mean of each equation. A constant that is left is
                remembered for the whole record, which then counts as one row: too little to fit that constant.
        """
        table = np.where(seen.valid, left.reshape(seen.valid.shape), 0.0)
        mean = (table**2).sum(axis=0) / seen.count
        many = table.shape[1]
        if about_mean:
            table = np.where(seen.valid, table - table.sum(axis=0) / seen.count, 0.0)
        times = np.array([_times(table[:, k], seen.valid[:, k], seen.lengths) for k in range(many)])
        return cls(np.sqrt(np.maximum(mean, 1.0)), 1.0 + np.minimum(mean, 1.0) ** 2 * (times - 1.0), seen.count)

    @property
    def weights(self) -> Array:
        """Of squared rows (equations,)."""
        return 1.0 / (self.scale**2 * self.times)

    def whiten(self, rows: Array) -> Array:
        """Rows of all equations (rows, ...) of unit variance for what they tell."""
        table = rows.reshape(-1, len(self.scale), *rows.shape[1:])
        return (table * np.sqrt(self.weights).reshape(-1, *[1] * (rows.ndim - 1))).reshape(rows.shape)

    def log_likelihood(self, squares: Array) -> float:
        """Of what structures leave, its size the most likely one but for the sensors' noise.

        Args:
            squares: sums over the rows of each equation (equations,).
        """
        mean = squares / self.count
        per_row = np.where(mean > 1.0, 0.5 * (1.0 + np.log(np.maximum(mean, 1.0))), 0.5 * mean)
        return -float((self.count / self.times * per_row).sum())


def _times(series: Array, valid: Flags, lengths: tuple[int, ...]) -> float:
    """Rows of one equation (rows,) that say one thing."""
    longest = max(lengths)
    products, pairs = np.zeros(longest), np.zeros(longest)
    for part in np.split(np.arange(len(series)), np.cumsum(lengths)[:-1]):
        products[: len(part)] += _products(series[part])
        pairs[: len(part)] += np.round(_products(valid[part].astype(float)))
    if products[0] <= 0.0:
        return 1.0
    enough = pairs > 0.5
    rho = products[enough] / pairs[enough] / (products[0] / pairs[0])
    chance = (pairs[enough] * rho**2 - 1.0)[1:]  # white rows have squares of 1/pairs
    return max(1.0, 1.0 + 2.0 * float(chance.sum()) / float(pairs[0]))


def _products(x: Array) -> Array:
    """Sums of products over every lag (rows,)."""
    spectrum = np.fft.rfft(x, 2 * len(x))
    return np.asarray(np.fft.irfft(np.abs(spectrum) ** 2, 2 * len(x))[: len(x)])
