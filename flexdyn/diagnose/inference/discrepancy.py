"""Coloured model error: one autoregressive process for each equation, estimated from what a structure leaves.

The rows come in whitened by the sensors' noise, so that their variance is 1 where the model is right. What a wrong
model adds is coloured. An autoregression of the sum is the innovations form of both (Ljung, 1999, 4.2):

    w_k = sum_i a_i w_(k-i) + s e_k,    s >= 1

The innovations e_k are what evidence counts. A slow error of T seconds then counts T over its correlation time.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]
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
    def of(cls, series: Array, runs: NDArray[np.intp], most: int = MOST_ORDER) -> Autoregression:
        """Estimate by Burg's method over the runs of rows that say something.

        Args:
            series: rows of one equation, white but for the model error (rows,).
            runs: how many such rows stand in line right before each row; -1 where a row says nothing (rows,).
            most: order at most.
        """
        valid = runs >= 0
        count = int(valid.sum())
        power = float((series[valid] ** 2).mean()) if count else 1.0
        table, variances = np.zeros((most + 1, most)), [max(power, 1e-300)]
        forward, backward = np.where(valid, series, 0.0), np.where(valid, series, 0.0)
        for order in range(1, most + 1):
            now, before = forward[1:], backward[:-1]
            pairs = runs[order:] >= order
            f, b = now[order - 1 :][pairs], before[order - 1 :][pairs]
            energy = float(f @ f + b @ b)
            if len(f) <= most or energy == 0.0:
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

    def innovations(self, rows: Array, runs: NDArray[np.intp]) -> Array:
        """Innovations of unit variance (rows, columns); zero where a row says nothing."""
        back = np.clip(runs, 0, self.order)
        white = rows.copy()
        for lag in range(1, self.order + 1):
            white[lag:] -= self.predictors[back[lag:], lag - 1, None] * rows[:-lag]
        white /= self.scale[back][:, None]
        white[runs < 0] = 0.0
        return white

    def log_scale(self, runs: NDArray[np.intp]) -> float:
        """Sum of the logarithms of the innovations' scales: half the log-determinant of the covariance."""
        return float(np.log(self.scale[np.clip(runs, 0, self.order)[runs >= 0]]).sum())

    @property
    def correlation_rows(self) -> float:
        """Rows over which the process is correlated: the sum of its autocorrelations."""
        if self.order == 0:
            return 1.0
        gain = 1.0 / max(1.0 - float(self.predictors[-1].sum()), 1e-3)
        variance = float(self.scale[0] ** 2)
        return max(1.0, gain**2 * float(self.scale[-1] ** 2) / variance)


@dataclass(frozen=True, eq=False)
class Discrepancy:
    """Model error of all equations.

    Attributes:
        processes: one an equation.
        runs: rows in line before each row, -1 where it says nothing (rows of an equation, equations).
    """

    processes: tuple[Autoregression, ...]
    runs: NDArray[np.intp]

    @classmethod
    def none(cls, runs: NDArray[np.intp]) -> Discrepancy:
        """No model error: what is left is the sensors' noise."""
        nothing = Autoregression(np.zeros((1, 0)), np.ones(1))
        return cls((nothing,) * runs.shape[1], runs)

    @classmethod
    def of(cls, left: Array, runs: NDArray[np.intp], most: int = MOST_ORDER) -> Discrepancy:
        """Estimated from what a structure leaves (rows of all equations,); with order 0 at most, its size alone."""
        series = left.reshape(runs.shape)
        return cls(tuple(Autoregression.of(series[:, k], runs[:, k], most) for k in range(runs.shape[1])), runs)

    def innovations(self, rows: Array) -> Array:
        """Innovations of unit variance (rows of all equations, columns)."""
        many = self.runs.shape[1]
        table = rows.reshape(len(self.runs), many, -1)
        white = np.empty_like(table)
        for k, process in enumerate(self.processes):
            white[:, k] = process.innovations(table[:, k], self.runs[:, k])
        return white.reshape(rows.shape)

    @property
    def log_scale(self) -> float:
        """Half the log-determinant that the model error adds to the covariance."""
        return sum(each.log_scale(self.runs[:, k]) for k, each in enumerate(self.processes))


def runs_of(mask: Flags, times: list[int], many: int) -> NDArray[np.intp]:
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
