"""Marginal likelihood of any structure from one Gram matrix.

    y = X beta + e,   e ~ N(0, I),   beta ~ N(mu, diag(lambda)^-1)
    log p(y | S) = -(y^T y + mu^T lambda mu)/2 + c^T A^-1 c/2 - log|A|/2 + log|lambda|/2
    A = G_SS + lambda_S,   c = X_S^T y + lambda_S mu_S

(Bishop, 2006, 3.5.) G = X^T X and X^T y are computed once. Columns that every structure has are eliminated
once (Schur's complement), so that a structure takes a Cholesky factor of its own columns alone.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import cho_solve, cholesky, solve_triangular
from scipy.special import log_ndtr

Array = NDArray[np.float64]
Indices = NDArray[np.intp]
BEYOND = 4.0
"""Standard deviations below zero from which a coefficient that may not be negative makes no sense."""


@dataclass(frozen=True, eq=False)
class Prior:
    """Independent Gaussian priors of all columns.

    Attributes:
        precision: 1/variance (columns,).
        mean: (columns,).
        positive: coefficients that may not be negative (columns,).
    """

    precision: Array
    mean: Array
    positive: NDArray[np.bool_]


@dataclass(frozen=True, eq=False)
class Estimate:
    """A structure's posterior.

    Attributes:
        columns: of the matrix, in the order of what follows (k,).
        log_likelihood: marginal, its positive coefficients' truncation included.
        mean: of the coefficients (k,).
        covariance: of the coefficients (k, k).
    """

    columns: Indices
    log_likelihood: float
    mean: Array
    covariance: Array


class Gram:
    """All columns' products, those of every structure eliminated.

    Args:
        X: white columns (rows, columns); those from `used` on are empty.
        y: white rows (rows,).
        prior: of the coefficients.
        base: the first so many columns are in every structure.
        used: columns that are there.
    """

    def __init__(self, X: Array, y: Array, prior: Prior, base: int, used: int) -> None:
        self.X, self.y, self.prior, self.base, self.used = X, y, prior, base, used
        first = X[:, :base]
        lam, mu = prior.precision[:base], prior.mean[:base]
        self.factor = lower_factor(first.T @ first + np.diag(lam))
        c = first.T @ y + lam * mu
        self.z = solve_triangular(self.factor, c, lower=True)
        self.constant = 0.5 * float(self.z @ self.z) - float(np.log(np.diag(self.factor)).sum())
        self.constant += 0.5 * float(np.log(lam).sum()) - 0.5 * (float(y @ y) + float(mu @ (lam * mu)))
        self.V = np.zeros((base, X.shape[1]))
        self.G, self.b = np.zeros((X.shape[1],) * 2), np.zeros(X.shape[1])
        self._fill(slice(base, used))

    def _fill(self, new: slice) -> None:
        """Products of new columns with all that are there, less what the base explains."""
        X = self.X[:, new]
        self.V[:, new] = solve_triangular(self.factor, self.X[:, : self.base].T @ X, lower=True)
        known = slice(self.base, new.stop)
        products = self.X[:, known].T @ X - self.V[:, known].T @ self.V[:, new]
        self.G[known, new], self.G[new, known] = products, products.T
        self.b[new] = X.T @ self.y - self.V[:, new].T @ self.z

    def grow(self, used: int) -> None:
        """More columns are there now."""
        self._fill(slice(self.used, used))
        self.used = used

    def estimate(self, columns: Indices) -> Estimate:
        """The posterior of one structure, of its own columns alone."""
        lam, mu = self.prior.precision[columns], self.prior.mean[columns]
        factor = lower_factor(self.G[np.ix_(columns, columns)] + np.diag(lam))
        c = self.b[columns] + lam * mu
        mean = cho_solve((factor, True), c)
        covariance = cho_solve((factor, True), np.eye(len(columns)))
        value = self.constant + 0.5 * float(c @ mean) - float(np.log(np.diag(factor)).sum())
        value += 0.5 * float(np.log(lam).sum()) - 0.5 * float(mu @ (lam * mu))
        bounded = self.prior.positive[columns]
        ratio = mean[bounded] / np.sqrt(np.maximum(np.diag(covariance)[bounded], 1e-300))
        value += float((log_ndtr(ratio) - log_ndtr(mu[bounded] * np.sqrt(lam[bounded]))).sum())
        return Estimate(columns, value, mean, covariance)

    def whole(self, columns: Indices) -> Estimate:
        """The same with the columns of every structure before its own."""
        own = self.estimate(columns)
        V = self.V[:, columns]
        inverse = solve_triangular(self.factor, np.eye(self.base), lower=True)
        first = inverse.T @ (self.z - V @ own.mean)
        cross = -inverse.T @ V @ own.covariance
        corner = inverse.T @ inverse + inverse.T @ V @ own.covariance @ V.T @ inverse
        covariance = np.block([[corner, cross], [cross.T, own.covariance]])
        order = np.concatenate([np.arange(self.base), columns]).astype(np.intp)
        return Estimate(order, own.log_likelihood, np.concatenate([first, own.mean]), covariance)

    def additions(self, columns: Indices, groups: Sequence[Indices]) -> Array:
        """What each group of columns would add to the log marginal likelihood of a structure.

        Args:
            columns: of the structure.
            groups: tables of columns (groups, width), one for each width.

        Returns:
            of all groups, in the order of the tables.
        """
        prior = self.prior
        c = self.b + prior.precision * prior.mean
        if not len(columns):
            return np.concatenate([self._added(table, None, c) for table in groups])
        factor = lower_factor(self.G[np.ix_(columns, columns)] + np.diag(prior.precision[columns]))
        V = solve_triangular(factor, self.G[columns], lower=True, check_finite=False)
        z = solve_triangular(factor, c[columns], lower=True)
        left = c - V.T @ z
        return np.concatenate([self._added(table, V, left) for table in groups])

    def _added(self, table: Indices, V: Array | None, left: Array) -> Array:
        lam, mu, c = self.prior.precision[table], self.prior.mean[table], left[table]
        S = self.G[table[:, :, None], table[:, None, :]]
        if V is not None:
            own = V[:, table]
            S = S - np.einsum("kgi,kgj->gij", own, own)
        place = np.arange(table.shape[1])
        S[:, place, place] = np.maximum(S[:, place, place], 0.0) + lam
        sign, logdet = np.linalg.slogdet(S)
        good = (sign > 0) & np.isfinite(logdet)
        S[~good] = np.eye(table.shape[1])
        inverse = np.linalg.inv(S)
        mean = np.einsum("gij,gj->gi", inverse, c)
        value = 0.5 * (c * mean).sum(axis=1) - 0.5 * logdet + 0.5 * np.log(lam).sum(axis=1)
        value -= 0.5 * (lam * mu**2).sum(axis=1)
        ratio = mean / np.sqrt(np.maximum(inverse[:, place, place], 1e-300))
        bounded = self.prior.positive[table]
        value += np.where(bounded, log_ndtr(ratio) - log_ndtr(mu * np.sqrt(lam)), 0.0).sum(axis=1)
        good &= ~(bounded & (ratio < -BEYOND)).any(axis=1)
        return np.where(good, value, -np.inf)


def lower_factor(A: Array) -> Array:
    """Lower Cholesky factor of a matrix that rounding may have left indefinite."""
    for lift in (0.0, 1e-10, 1e-7, 1e-4):
        try:
            return np.asarray(cholesky(A + lift * np.diag(np.diag(A)), lower=True, check_finite=False))
        except np.linalg.LinAlgError:
            continue
    raise ArithmeticError("the products of the columns are not finite")
