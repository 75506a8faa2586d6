"""A study's results in numbers: failures with reasons, every metric, and its dependence on each drawn number."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from flexdyn.arrays import Array

FIFTH = 0.2
SUMMARY_QUANTILES = (0.05, 0.25, 0.5, 0.75, 0.95)
"""Quantiles of metrics."""
_NUMBER = re.compile(r"(?<![\w.])[-+]?\d+(\.\d*)?([eE][-+]?\d+)?(?!\w)")


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
    from scipy.stats import spearmanr  # here, as `import flexdyn` loads no scipy

    correlation = float(spearmanr(x, y).statistic)
    mean = float(y.mean())
    ends = np.quantile(x, [FIFTH, 1.0 - FIFTH])
    low, high = float(y[x <= ends[0]].mean()) - mean, float(y[x >= ends[1]].mean()) - mean
    return Sensitivity(correlation, 1.96 / float(np.sqrt(len(x) - 1)), low, high)


@dataclass(frozen=True)
class Reason:
    """A reason why runs failed or lack a metric.

    Attributes:
        text: of the first run; for the others its numbers may differ.
        runs: number of these runs.
        first: the first of these runs.
    """

    text: str
    runs: int
    first: int


@dataclass(frozen=True)
class MetricSummary:
    """A metric over all runs that have it; if no run has it, all numbers except the counts are None.

    Attributes:
        name: of the metric.
        unit: of its numbers.
        runs: number of runs that have it.
        mean: over these runs.
        std: standard deviation over these runs (n - 1); None for one run.
        least: smallest value.
        quantiles: by share of runs below, 0.05 to 0.95.
        greatest: largest value.
        worst: the run with the largest value.
    """

    name: str
    unit: str
    runs: int
    mean: float | None
    std: float | None
    least: float | None
    quantiles: Mapping[float, float]
    greatest: float | None
    worst: int | None


@dataclass(frozen=True)
class ParameterSummary:
    """A number that varies.

    Attributes:
        name: its path.
        unit: its unit.
        least: smallest value of all finished runs.
        greatest: largest value of all finished runs.
        sensitivities: its influence on each metric, the strongest first; a metric is left out if it cannot be computed.
    """

    name: str
    unit: str
    least: float | None
    greatest: float | None
    sensitivities: Mapping[str, Sensitivity]


@dataclass(frozen=True)
class Summary:
    """A study's results in numbers.

    Attributes:
        path: of the store.
        runs: of the study.
        done: number of finished runs, failed ones included.
        failed: number of runs without channels.
        reasons: why runs failed or lack a metric, the most frequent first.
        metrics: in the study's order.
        parameters: in the study's order.
    """

    path: str
    runs: int
    done: int
    failed: int
    reasons: tuple[Reason, ...]
    metrics: tuple[MetricSummary, ...]
    parameters: tuple[ParameterSummary, ...]

    def to_dict(self) -> dict[str, Any]:
        """In a form for JSON."""
        return asdict(self)


def metric_summary(name: str, unit: str, values: Array) -> MetricSummary:
    """A metric over its runs.

    Args:
        name: of the metric.
        unit: of it.
        values: by run (runs,); NaN where a run has none.
    """
    there = values[np.isfinite(values)]
    if not len(there):
        return MetricSummary(name, unit, 0, None, None, None, {}, None, None)
    return MetricSummary(
        name=name,
        unit=unit,
        runs=len(there),
        mean=float(there.mean()),
        std=float(there.std(ddof=1)) if len(there) > 1 else None,
        least=float(there.min()),
        quantiles=dict(zip(SUMMARY_QUANTILES, np.quantile(there, SUMMARY_QUANTILES).tolist(), strict=True)),
        greatest=float(there.max()),
        worst=int(np.nanargmax(values)),
    )


def parameter_summary(name: str, unit: str, values: Array, metrics: Mapping[str, Array]) -> ParameterSummary:
    """A parameter over the finished runs, and its influence on each metric.

    Args:
        name: its path.
        unit: its unit.
        values: by run (runs,); NaN if a run is not done.
        metrics: by name, by run (runs,).
    """
    found = {metric: sensitivity(values, column) for metric, column in metrics.items()}
    kept = {metric: each for metric, each in found.items() if each is not None}
    ordered = dict(sorted(kept.items(), key=lambda entry: -abs(entry[1].rank_correlation)))
    there = values[np.isfinite(values)]
    least, greatest = (float(there.min()), float(there.max())) if len(there) else (None, None)
    return ParameterSummary(name, unit, least, greatest, ordered)


def reasons_of(statuses: Iterable[tuple[int, str]]) -> tuple[Reason, ...]:
    """Count the reasons; those that differ only in numbers count as one.

    Args:
        statuses: run and status of all runs with a reason.
    """
    found: dict[str, list[Any]] = {}
    for run, status in statuses:
        for text in re.split(r"; (?=metric )", status) if status.startswith("metric ") else [status]:
            entry = found.setdefault(_NUMBER.sub("#", text), [text, 0, run])
            entry[1] += 1
    ordered = sorted(found.values(), key=lambda entry: (-entry[1], entry[2]))
    return tuple(Reason(*entry) for entry in ordered)
