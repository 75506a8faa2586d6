"""Log marginal likelihood that blocks of columns add, from products of what nothing else explains, and their priors."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.linalg import cholesky
from scipy.special import log_ndtr

from flexdyn.arrays import Array, Flags

NEGATIVE_SIGMAS = 4.0
"""A positive coefficient is rejected if its estimate is below zero by more than this number of standard deviations."""


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
    positive: Flags


def added_evidence(S: Array, c: Array, lam: Array, mu: Array, bounded: Flags) -> tuple[Array, Array]:
    """What groups of columns add to the log marginal likelihood, and their coefficients.

    Args:
        S: products of the columns, all that is there eliminated; gets the priors' precision (groups, width, width).
        c: products with the rows, likewise, plus precision times mean of the priors (groups, width).
        lam: precision of the priors (groups, width).
        mu: means of the priors (groups, width).
        bounded: coefficients that may not be negative (groups, width).

    Returns:
        (groups,), -inf where a coefficient that may not be negative clearly is; and (groups, width).
    """
    place = np.arange(S.shape[1])
    S[:, place, place] = np.maximum(S[:, place, place], 0.0) + lam
    sign, logdet = np.linalg.slogdet(S)
    good = (sign > 0) & np.isfinite(logdet)
    S[~good] = np.eye(S.shape[1])
    inverse = np.linalg.inv(S)
    mean = np.einsum("gij,gj->gi", inverse, c)
    value = 0.5 * (c * mean).sum(axis=1) - 0.5 * logdet + 0.5 * np.log(lam).sum(axis=1)
    value -= 0.5 * (lam * mu**2).sum(axis=1)
    ratio = mean / np.sqrt(np.maximum(inverse[:, place, place], 1e-300))
    value += np.where(bounded, log_ndtr(ratio) - log_ndtr(mu * np.sqrt(lam)), 0.0).sum(axis=1)
    good &= ~(bounded & (ratio < -NEGATIVE_SIGMAS)).any(axis=1)
    return np.where(good, value, -np.inf), mean


def lower_factor(A: Array) -> Array:
    """Lower Cholesky factor of a matrix that rounding may have left indefinite."""
    for lift in (0.0, 1e-10, 1e-7, 1e-4):
        try:
            return np.asarray(cholesky(A + lift * np.diag(np.diag(A)), lower=True, check_finite=False))
        except np.linalg.LinAlgError:
            continue
    raise ArithmeticError("the products of the columns are not finite")
