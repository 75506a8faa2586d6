"""Least squares over whitened rows with Gaussian priors."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from flexdyn.arrays import Array
from flexdyn.diagnose.lazy import lazy

ROWS_PER_COLUMN = 16
"""Rows of a block of a tall matrix, per column."""


@dataclass(frozen=True, eq=False)
class Regression:
    """``min |y + X b|^2 + sum ((b_k - centre_k)/sigma_k)^2``.

    The last columns may be nuisances: they are fitted again every time, and their steps are not kept.

    Attributes:
        y: normalised residual (rows,).
        X: whitened derivatives (rows, columns).
        centre: of the priors (columns,).
        sigma: of the priors (columns,); inf: none.
        rows: number of rows that are not masked.
        nuisances: number of the last columns that are fitted again every time.
    """

    y: Array
    X: Array
    centre: Array
    sigma: Array
    rows: int
    nuisances: int = 0

    @lazy
    def _scale(self) -> Array:
        """Lengths of the columns with their priors (columns,)."""
        length = np.sqrt(np.einsum("ij,ij->j", self.X, self.X) + self.sigma**-2.0)
        return np.where(length > 0.0, length, 1.0)

    @lazy
    def _turned(self) -> tuple[Array, Array]:
        """R of the scaled columns (columns, columns), and Q^T of the target (columns,)."""
        rows, count = self.X.shape
        whole = np.empty((rows + count, count + 1))
        np.divide(self.X, self._scale, out=whole[:rows, :count])
        whole[rows:, :count] = np.diag(1.0 / (self.sigma * self._scale))
        whole[:, count] = self._target
        R = _triangle(whole)
        return R[:count, :count], R[:count, count]

    @property
    def _target(self) -> Array:
        return np.concatenate([self.y, -self.centre / self.sigma])

    @lazy
    def values(self) -> Array:
        """The coefficients b (columns,)."""
        return np.asarray(-np.linalg.lstsq(*self._turned, rcond=1e-12)[0] / self._scale)

    @lazy
    def left(self) -> Array:
        """Residuals of rows and priors (rows + columns,)."""
        return np.asarray(self._target + np.concatenate([self.X @ self.values, self.values / self.sigma]))

    @lazy
    def at_zero(self) -> float:
        """Sum of squares without a step, except of the nuisance columns, whose prior is centred at 0."""
        first = self.X.shape[1] - self.nuisances
        if not self.nuisances:
            return float(self._target @ self._target)
        block = np.vstack([self.X[:, first:], np.diag(1.0 / self.sigma)[:, first:]]) / self._scale[first:]
        best = np.linalg.lstsq(block, self._target, rcond=1e-12)[0]
        after = self._target - block @ best
        return float(after @ after)

    @property
    def with_priors(self) -> Array:
        """X, and below it the rows of the priors (rows + columns, columns)."""
        return np.vstack([self.X, np.diag(1.0 / self.sigma)])

    @property
    def chi2(self) -> float:
        """Sum of squares of rows and priors."""
        return float(self.left @ self.left)

    @property
    def data_chi2(self) -> float:
        """Sum of squares of the rows alone."""
        rows = self.left[: len(self.y)]
        return float(rows @ rows)

    @lazy
    def covariance(self) -> Array:
        """Covariance of the coefficients (columns, columns), for white rows of unit variance."""
        inverse = np.linalg.pinv(self._turned[0], rcond=1e-12)
        return np.asarray(inverse @ inverse.T / np.outer(self._scale, self._scale))

    def sandwich(self, block: int) -> Array:
        """Covariance of the coefficients (columns, columns) for correlated rows.

        ``H^-1 (sum_b g_b g_b^T + P) H^-1`` with the gradients g_b of blocks of rows, which are assumed independent, the
        information H and that of the priors P (White, 1980; Newey and West, 1987).

        Args:
            block: number of rows in a block, large against the correlation length.
        """
        bread = self.covariance
        rows = len(self.y)
        each = self.X * self.left[:rows, None]
        gradients = np.add.reduceat(each, np.arange(0, rows, block), axis=0)
        meat = gradients.T @ gradients + np.diag(1.0 / self.sigma**2)
        return np.asarray(bread @ meat @ bread)


def _triangle(tall: Array) -> Array:
    """R of a tall matrix: of blocks of rows that fit into the cache, then of their results (Demmel et al., 2012)."""
    columns = tall.shape[1]
    blocks = len(tall) // (ROWS_PER_COLUMN * columns)
    whole = blocks * ROWS_PER_COLUMN * columns
    if blocks > 1:
        heads = np.asarray(np.linalg.qr(tall[:whole].reshape(blocks, -1, columns), mode="r"))
        tall = np.vstack([heads.reshape(-1, columns), tall[whole:]])
    return np.asarray(np.linalg.qr(tall, mode="r"))
