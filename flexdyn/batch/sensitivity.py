"""How a number that was drawn and a metric go together."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
FIFTH = 0.2


@dataclass(frozen=True)
class Sensitivity:
    """What a parameter does to a metric, over all runs that have the metric.

    Attributes:
        rank_correlation: Spearman's: 1 where the metric always rises with the parameter, -1 where it always falls;
            by chance alone it stays below `chance` in 95 of 100 studies.
        chance: 1.96 / sqrt(runs - 1).
        low: mean of the metric over the fifth of runs with the lowest parameter, less the mean over all.
        high: the same of the fifth with the highest.
    """

    rank_correlation: float
    chance: float
    low: float
    high: float


def sensitivity(parameter: Array, metric: Array) -> Sensitivity | None:
    """How a parameter and a metric go together.

    Args:
        parameter: by run (runs,).
        metric: by run (runs,); NaN where a run has none.

    Returns:
        None where that cannot be said: fewer than three runs, or one of the two never varies.
    """
    there = np.isfinite(parameter) & np.isfinite(metric)
    x, y = parameter[there], metric[there]
    if len(x) < 3 or x.min() == x.max() or y.min() == y.max():
        return None
    correlation = float(np.corrcoef(ranks(x), ranks(y))[0, 1])
    mean = float(y.mean())
    ends = np.quantile(x, [FIFTH, 1.0 - FIFTH])
    low, high = float(y[x <= ends[0]].mean()) - mean, float(y[x >= ends[1]].mean()) - mean
    return Sensitivity(correlation, 1.96 / float(np.sqrt(len(x) - 1)), low, high)


def ranks(values: Array) -> Array:
    """Places of values in their order, from 0; those that are equal share the mean of theirs."""
    _, group, counts = np.unique(values, return_inverse=True, return_counts=True)
    last = np.cumsum(counts)
    return np.asarray((last - 0.5 * (counts + 1))[group])
