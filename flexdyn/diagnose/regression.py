"""Least squares over whitened rows with Gaussian priors, and what one more column would gain."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from flexdyn.diagnose.lazy import lazy

Array = NDArray[np.float64]
LEFT_OVER = 1e-5
"""Share of a column's length that must be its own, outside what the others span."""
AGAIN = 1e-3
"""The same below which rounding would show, so that what others span is taken off once more."""

BLOCK = 16
"""Rows of a block of a tall matrix, for each of its columns."""


@dataclass(frozen=True)
class Gain:
    """What one more group of columns does.

    Attributes:
        chi2: drop of the sum of squares.
        values: least-squares coefficients of the columns.
    """

    chi2: float
    values: Array


@dataclass(frozen=True, eq=False)
class Regression:
    """``min |y + X b|^2 + sum ((b_k - centre_k)/sigma_k)^2``.

    The last columns may be nuisances: they are fitted anew every time and no step of them is kept.

    Attributes:
        y: whitened residual (rows,).
        X: whitened derivatives (rows, columns).
        centre: of the priors (columns,).
        sigma: of the priors (columns,); inf: none.
        rows: that say something.
        nuisances: how many of the last columns are fitted anew every time.
    """

    y: Array
    X: Array
    centre: Array
    sigma: Array
    rows: int
    nuisances: int = 0

    @lazy
    def _whole(self) -> Array:
        return np.vstack([self.X, np.diag(1.0 / self.sigma)])

    @lazy
    def _scale(self) -> Array:
        length = np.sqrt((self._whole**2).sum(axis=0))
        return np.where(length > 0.0, length, 1.0)

    @lazy
    def _Q(self) -> Array:
        """Orthonormal columns that span those of rows and priors; many fits never ask what lies outside."""
        return np.asarray(np.linalg.qr(self._whole / self._scale)[0])

    @lazy
    def _turned(self) -> tuple[Array, Array]:
        """R of the scaled columns (columns, columns), and Q^T of the target (columns,)."""
        R, count = _triangle(np.column_stack([self._whole / self._scale, self._target])), self.X.shape[1]
        return R[:count, :count], R[:count, count]

    @lazy
    def _target(self) -> Array:
        return np.concatenate([self.y, -self.centre / self.sigma])

    @lazy
    def values(self) -> Array:
        """The coefficients b (columns,)."""
        return np.asarray(-np.linalg.lstsq(*self._turned, rcond=1e-12)[0] / self._scale)

    @lazy
    def left(self) -> Array:
        """What is left of rows and priors (rows + columns,)."""
        return np.asarray(self._target + self._whole @ self.values)

    @lazy
    def at_zero(self) -> float:
        """Sum of squares where no step is taken, but for the nuisance columns, whose prior is centred on none."""
        nuisance = slice(self.X.shape[1] - self.nuisances, self.X.shape[1])
        if not self.nuisances:
            return float(self._target @ self._target)
        block = self._whole[:, nuisance] / self._scale[nuisance]
        best = np.linalg.lstsq(block, self._target, rcond=1e-12)[0]
        after = self._target - block @ best
        return float(after @ after)

    @property
    def chi2(self) -> float:
        """Sum of squares of rows and priors."""
        return float(self.left @ self.left)

    @property
    def data_chi2(self) -> float:
        """Sum of squares of the rows alone."""
        rows = self.left[: len(self.y)]
        return float(rows @ rows)

    @property
    def prior_chi2(self) -> float:
        """Sum of squares of the priors alone: how far the file's numbers had to be bent."""
        return self.chi2 - self.data_chi2

    @lazy
    def covariance(self) -> Array:
        """Of the coefficients (columns, columns), for white rows of unit variance."""
        inverse = np.linalg.pinv(self._turned[0], rcond=1e-12)
        return np.asarray(inverse @ inverse.T / np.outer(self._scale, self._scale))

    def sandwich(self, block: int) -> Array:
        """Covariance of the coefficients (columns, columns) that holds for coloured rows.

        ``H^-1 (sum_b g_b g_b^T + P) H^-1`` with the gradients g_b of blocks of rows, which are taken to be independent
        of one another, H the information and P that of the priors (White, 1980; Newey and West, 1987).

        Args:
            block: rows in a block, long against the rows' correlation.
        """
        bread = self.covariance
        rows = len(self.y)
        each = self.X * self.left[:rows, None]
        gradients = np.add.reduceat(each, np.arange(0, rows, block), axis=0)
        meat = gradients.T @ gradients + np.diag(1.0 / self.sigma**2)
        return np.asarray(bread @ meat @ bread)

    def gain(self, columns: Array, positive: Sequence[bool] = (), *, fixed: bool = False) -> Gain:
        """What more columns (rows, k) would gain, everything else being fitted again.

        Args:
            columns: whitened derivatives.
            positive: which coefficients may not be negative.
            fixed: their coefficients are 1 and not fitted.
        """
        own, scale = self._own(columns)
        if fixed:
            after = self.left + own.sum(axis=1) if own.ndim == 2 else self.left + own
            return Gain(self.chi2 - float(after @ after), np.ones(columns.shape[1]))
        values = np.zeros(columns.shape[1])
        length = np.sqrt(np.einsum("ij,ij->j", own, own))
        free = [k for k in range(len(values)) if length[k] > LEFT_OVER * scale[k] > 0.0]
        while free:
            unit = own[:, free] / length[free]
            fitted = -np.linalg.lstsq(unit, self.left, rcond=1e-9)[0]
            wrong = {
                k for k, value in zip(free, fitted, strict=True) if k < len(positive) and positive[k] and value < 0
            }
            if not wrong:
                after = self.left + unit @ fitted
                values[free] = fitted / length[free]
                return Gain(self.chi2 - float(after @ after), values)
            free = [k for k in free if k not in wrong]
        return Gain(0.0, values)

    def freed(self, k: int) -> float:
        """What dropping the prior of one column would gain."""
        unit = np.zeros(len(self.left))
        unit[len(self.y) + k] = 1.0
        Q = self._Q
        own = unit - Q @ (Q.T @ unit)
        length = float(own @ own)
        return 0.0 if length < 1e-10 else float(own @ self.left) ** 2 / length

    def _own(self, columns: Array) -> tuple[Array, Array]:
        """Columns outside the span of what is fitted, and their lengths before that."""
        padded = np.vstack([columns, np.zeros((self.X.shape[1], columns.shape[1]))])
        Q = self._Q
        own = padded - Q @ (Q.T @ padded)
        length = np.sqrt(np.einsum("ij,ij->j", padded, padded))
        if (np.einsum("ij,ij->j", own, own) < (AGAIN * length) ** 2).any():
            own -= Q @ (Q.T @ own)
        return own, length


def _triangle(tall: Array) -> Array:
    """R of a tall matrix: of blocks of rows that stay in the cache, then of their own (Demmel et al., 2012)."""
    columns = tall.shape[1]
    blocks = len(tall) // (BLOCK * columns)
    whole = blocks * BLOCK * columns
    if blocks > 1:
        heads = np.asarray(np.linalg.qr(tall[:whole].reshape(blocks, -1, columns), mode="r"))
        tall = np.vstack([heads.reshape(-1, columns), tall[whole:]])
    return np.asarray(np.linalg.qr(tall, mode="r"))
