"""The dependence of a metric on a drawn number."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from flexdyn.checks import Array

FIFTH = 0.2


@dataclass(frozen=True)
class Sensitivity:
    """The influence of a parameter on a metric, over all runs that have the metric.

    Attributes:
        rank_correlation: Spearman's: 1 if the metric always rises with the parameter, -1 if it always falls; by chance
            alone it is below `chance` in 95 of 100 studies.
        chance: 1.96 / sqrt(runs - 1).
        low: mean of the metric over the fifth of runs with the lowest parameter, minus the mean over all.
        high: the same for the fifth with the highest.
    """

    rank_correlation: float
    chance: float
    low: float
    high: float


def sensitivity(parameter: Array, metric: Array) -> Sensitivity | None:
    """Compute the influence of a parameter on a metric.

    Args:
        parameter: by run (runs,).
        metric: by run (runs,); NaN if a run has none.

    Returns:
        The influence; None if there are fewer than three runs, or if one of the two never varies.
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
    """Ranks of values, from 0; equal values have the mean of their ranks."""
    _, group, counts = np.unique(values, return_inverse=True, return_counts=True)
    last = np.cumsum(counts)
    return np.asarray((last - 0.5 * (counts + 1))[group])
