"""Autoregression of one equation's rows: it whitens what a spectrum is taken of."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from flexdyn.arrays import Array, Flags, Indices

MOST_ORDER = 12
"""Order of an autoregression at most; the order is chosen below it by BIC. Twelve rows are some 0.1 s."""


@dataclass(frozen=True, eq=False)
class Autoregression:
    """Predictors of every order up to the chosen one, and their innovations.

    Attributes:
        predictors: row k predicts from the k rows before (order + 1, order).
        scale: standard deviation of the innovations of each order, at least 1 (order + 1,).
    """

    predictors: Array
    scale: Array

    @property
    def order(self) -> int:
        """Rows that the predictor looks back at."""
        return len(self.scale) - 1

    @classmethod
    def of(cls, series: Array, runs: Indices) -> Autoregression:
        """Estimate by Burg's method over the runs of rows that say something.

        Args:
            series: rows of one equation, white but for the model error (rows,).
            runs: how many such rows stand in line right before each row; -1 where a row says nothing (rows,).
        """
        valid = runs >= 0
        count = int(valid.sum())
        power = float((series[valid] ** 2).mean()) if count else 1.0
        table, variances = np.zeros((MOST_ORDER + 1, MOST_ORDER)), [max(power, 1e-300)]
        forward, backward = np.where(valid, series, 0.0), np.where(valid, series, 0.0)
        for order in range(1, MOST_ORDER + 1):
            now, before = forward[1:], backward[:-1]
            pairs = runs[order:] >= order
            f, b = now[order - 1 :][pairs], before[order - 1 :][pairs]
            energy = float(f @ f + b @ b)
            if len(f) <= MOST_ORDER or energy == 0.0:
                break
            reflection = 2.0 * float(f @ b) / energy
            previous = table[order - 1, : order - 1]
            table[order, : order - 1] = previous - reflection * previous[::-1]
            table[order, order - 1] = reflection
            variances.append(variances[-1] * max(1.0 - reflection**2, 1e-12))
            new_forward, new_backward = now - reflection * before, before - reflection * now
            forward = np.concatenate([[0.0], new_forward])
            backward = np.concatenate([[0.0], new_backward])
        bic = [count * math.log(max(v, 1.0)) + k * math.log(max(count, 2)) for k, v in enumerate(variances)]
        best = int(np.argmin(bic))
        scale = np.sqrt(np.maximum(variances[: best + 1], 1.0))
        return cls(table[: best + 1, :best], scale)

    def innovations(self, rows: Array, runs: Indices) -> Array:
        """Innovations of unit variance (rows, columns); zero where a row says nothing."""
        back = np.clip(runs, 0, self.order)
        white = rows.copy()
        for lag in range(1, self.order + 1):
            white[lag:] -= self.predictors[back[lag:], lag - 1, None] * rows[:-lag]
        white /= self.scale[back][:, None]
        white[runs < 0] = 0.0
        return white


def runs_of(mask: Flags, times: list[int], many: int) -> Indices:
    """Rows in line before each row, by equation (rows of an equation, equations).

    Args:
        mask: rows that say nothing, of all equations (rows,).
        times: rows of an equation in each recording; runs end with a recording.
        many: equations.
    """
    hidden = mask.reshape(-1, many)
    runs = np.empty(hidden.shape, np.intp)
    begins = set(np.cumsum([0, *times]).tolist())
    current = np.full(many, -1, np.intp)
    for k, row in enumerate(hidden):
        if k in begins:
            current[:] = -1
        current = np.where(row, -1, current + 1)
        runs[k] = current
    return runs
