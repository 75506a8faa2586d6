"""Marginal likelihood of any structure from the products of all columns.

    y = X beta + e,   beta ~ N(mu, diag(lambda)^-1)

The rows of equation k have the weight w_k. With A = X^T W X + lambda and c = X^T W y + lambda mu, the coefficients are
A^-1 c (Bishop, 2006, 3.5). Products are computed once for each equation; weights only add them up. Columns that every
structure has are eliminated once (Schur's complement), so that a structure takes a Cholesky factor of its own columns
alone. A block of columns that is added needs its products with itself and with those that are there, and no others.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.linalg import cho_solve, solve_triangular
from scipy.special import log_ndtr

from flexdyn.arrays import Array, Indices
from flexdyn.diagnose.inference.eliminated import Eliminated
from flexdyn.diagnose.inference.evidence import Prior, added_evidence, lower_factor
from flexdyn.diagnose.inference.products import Products


@dataclass(frozen=True, eq=False)
class Estimate:
    """A structure's posterior.

    Attributes:
        columns: of the matrix, in the order of what follows (k,).
        log_volume: of the posterior over that of the prior; truncation of positive coefficients included.
        mean: of the coefficients (k,).
        covariance: of the coefficients (k, k).
    """

    columns: Indices
    log_volume: float
    mean: Array
    covariance: Array


class Gram:
    """All columns' products under weights of the equations, those of every structure eliminated.

    Args:
        products: of the columns.
        weights: of the equations' squared rows.
        prior: of the coefficients.
        base: the first so many columns are in every structure.
    """

    def __init__(self, products: Products, weights: Array, prior: Prior, base: int) -> None:
        self.products, self.weights, self.prior, self.base, self.used = products, weights, prior, base, products.count
        products.hold(base)
        capacity = len(prior.mean)
        self.b, self.V = np.zeros(capacity), np.zeros((base, capacity))
        self.own = np.zeros((capacity, 0))
        self._rows: dict[int, Array] = {}
        first = products.weighted(weights, np.arange(base))
        lam, mu = prior.precision[:base], prior.mean[:base]
        self.factor = lower_factor(first[:, :base] + np.diag(lam))
        self.z = solve_triangular(self.factor, weights @ products.b[:, :base] + lam * mu, lower=True)
        self.log_volume = 0.5 * float(np.log(lam).sum()) - float(np.log(np.diag(self.factor)).sum())
        self.inverse = solve_triangular(self.factor, np.eye(base), lower=True)
        self._eliminate(first, 0)
        inverse, V = self.inverse, self.V

        def by(columns: Indices) -> Array:  # not a method: that would keep the products until a search for cycles
            """Coefficients of the base by other columns (base, columns)."""
            return np.asarray(inverse.T @ V[:, columns])

        self.eliminated = Eliminated(products, weights, lam, inverse.T @ self.z, by)

    def _eliminate(self, first: Array, new: int) -> None:
        """Take what the base explains off the products of new columns (base, new columns)."""
        here = slice(new, self.used)
        V = self.V[:, here] = self.inverse @ first
        self.b[here] = self.weights @ self.products.b[:, here] - V.T @ self.z
        own = self.products.weighted_own(self.weights, new)
        for d in range(min(own.shape)):
            own[: len(own) - d, d] -= np.einsum("ki,ki->i", V[:, : len(own) - d], V[:, d:])
        more = own.shape[1] - self.own.shape[1]
        if more > 0:
            self.own = np.concatenate([self.own, np.zeros((len(self.own), more))], axis=1)
        self.own[here] = own
        for c, row in self._rows.items():
            row[here] = self._row(c, new)

    def _row(self, c: int, first: int = 0) -> Array:
        """Products of one column, the base eliminated, with all from the first one on."""
        row = self.products.weighted(self.weights, np.array([c]), first)[0]
        return np.asarray(row - self.V[:, c] @ self.V[:, first : self.used])

    def rows(self, columns: Indices) -> Array:
        """Products of a structure's columns, the base eliminated, with all that are there (columns, used)."""
        self.products.take_up(columns)
        for c in columns.tolist():
            if c not in self._rows:
                self._rows[c] = np.zeros(len(self.b))
                self._rows[c][: self.used] = self._row(c)
        return np.array([self._rows[c][: self.used] for c in columns.tolist()]).reshape(len(columns), self.used)

    def between(self, columns: Indices, others: Indices) -> Array:
        """Products of columns with others, the base eliminated (columns, others)."""
        return self.eliminated.between(columns, others)

    def squares(self, own: Estimate) -> Array:
        """Sums of the squares that a structure leaves at its coefficients (equations,).

        Args:
            own: its posterior, of its own columns alone.
        """
        return self.eliminated.squares(own.columns, own.mean)

    def grow(self) -> None:
        """More columns are there now."""
        first, self.used = self.used, self.products.count
        self._eliminate(self.products.weighted(self.weights, np.arange(self.base), first), first)

    def estimate(self, columns: Indices) -> Estimate:
        """The posterior of one structure, of its own columns alone."""
        lam, mu = self.prior.precision[columns], self.prior.mean[columns]
        factor = lower_factor(self.between(columns, columns) + np.diag(lam))
        right = np.column_stack([np.eye(len(columns)), self.b[columns] + lam * mu])
        solved = cho_solve((factor, True), right, overwrite_b=True, check_finite=False)
        covariance, mean = solved[:, :-1], solved[:, -1]
        volume = self.log_volume + 0.5 * float(np.log(lam).sum()) - float(np.log(np.diag(factor)).sum())
        bounded = self.prior.positive[columns]
        ratio = mean[bounded] / np.sqrt(np.maximum(np.diag(covariance)[bounded], 1e-300))
        volume += float((log_ndtr(ratio) - log_ndtr(mu[bounded] * np.sqrt(lam[bounded]))).sum())
        return Estimate(columns, volume, mean, covariance)

    def with_base(self, own: Estimate) -> tuple[Indices, Array]:
        """Columns of a structure with those of every structure before them, and the coefficients of all."""
        first = self.inverse.T @ (self.z - self.V[:, own.columns] @ own.mean)
        order = np.concatenate([np.arange(self.base), own.columns]).astype(np.intp)
        return order, np.concatenate([first, own.mean])

    def of_base(self, own: Estimate, which: Indices) -> tuple[Array, Array]:
        """Mean and standard deviation of some coefficients that every structure has (k,).

        Args:
            own: a structure's posterior, of its own columns alone.
            which: columns among those of every structure (k,).
        """
        w = self.inverse[:, which]
        T = w.T @ self.V[:, own.columns]
        variance = (w**2).sum(axis=0) + ((T @ own.covariance) * T).sum(axis=1)
        return w.T @ self.z - T @ own.mean, np.sqrt(variance)

    def whole(self, columns: Indices) -> Estimate:
        """The posterior of one structure, the columns of every structure before its own."""
        own = self.estimate(columns)
        V = self.V[:, columns]
        cross = -self.inverse.T @ V @ own.covariance
        corner = self.inverse.T @ (np.eye(self.base) + V @ own.covariance @ V.T) @ self.inverse
        covariance = np.block([[corner, cross], [cross.T, own.covariance]])
        order, mean = self.with_base(own)
        return Estimate(order, own.log_volume, mean, covariance)

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
        rows = self.rows(columns)
        factor = lower_factor(rows[:, columns] + np.diag(prior.precision[columns]))
        V = solve_triangular(factor, rows, lower=True, check_finite=False)
        z = solve_triangular(factor, c[columns], lower=True)
        left = c[: self.used] - V.T @ z
        return np.concatenate([self._added(table, V, left) for table in groups])

    def _added(self, table: Indices, V: Array | None, left: Array) -> Array:
        lam, mu, c = self.prior.precision[table], self.prior.mean[table], left[table]
        one, other = table[:, :, None], table[:, None, :]
        low = np.minimum(one, other)
        S = self.own[low, np.maximum(one, other) - low]
        if V is not None:
            own = V[:, table]
            S = S - np.einsum("kgi,kgj->gij", own, own)
        return added_evidence(S, c, lam, mu, self.prior.positive[table])[0]
