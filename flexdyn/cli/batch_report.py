"""The output of flexdyn batch: a study's results as tables, and one extracted run."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from flexdyn.cli.output import number, table

if TYPE_CHECKING:
    from flexdyn.batch.extract import Extracted
    from flexdyn.batch.summary import Summary

METRICS = ("metric", "unit", "runs", "mean", "std", "least", "5 %", "median", "95 %", "greatest", "of run")
REPORT_QUANTILES = (0.05, 0.5, 0.95)
STRONGEST = 3
"""Number of metrics that are listed for each parameter."""


def summary_parts(summary: Summary) -> list[Any]:
    """Texts and tables of a study's results.

    Args:
        summary: of them.
    """
    pending = summary.runs - summary.done
    head = f"{summary.path}: {summary.done} of {summary.runs} runs done, {summary.failed} of them failed"
    parts: list[Any] = [head + (f"; {pending} to do: --resume" if pending else "")]
    if summary.reasons:
        rows = [(reason.runs, reason.first, reason.text) for reason in summary.reasons]
        parts.append(table("What failed", ("runs", "first", "reason"), rows, right=("runs", "first")))
    if summary.metrics:
        rows_ = [
            (
                each.name,
                each.unit or "-",
                each.runs,
                *map(number, (each.mean, each.std, each.least)),
                *(number(each.quantiles.get(share)) for share in REPORT_QUANTILES),
                number(each.greatest),
                "-" if each.worst is None else each.worst,
            )
            for each in summary.metrics
        ]
        parts.append(table("Metrics", METRICS, rows_, right=METRICS[2:]))
    columns = ("parameter", "unit", "least", "greatest", "rank correlation with metrics")
    varied = [
        (each.name, each.unit or "-", number(each.least), number(each.greatest), _correlations(each.sensitivities))
        for each in summary.parameters
    ]
    return [*parts, table("What varies", columns, varied, right=columns[2:4])]


def extracted_lines(taken: Extracted) -> list[Any]:
    """The text for a run that was extracted from a study.

    Args:
        taken: its files and the command line that makes it.
    """
    numbers = [(path, number(value, 8)) for path, value in taken.values.items()]
    files = ", ".join(str(path) for path in (taken.model, taken.command) if path is not None)
    return [f"run {taken.run} in {files}", table("Drawn", ("number", "value"), numbers, right=("value",)), taken.line]


def _correlations(sensitivities: Any) -> str:
    """The strongest correlations; those that may be chance are in parentheses."""
    shown = []
    for name, each in list(sensitivities.items())[:STRONGEST]:
        text = f"{each.rank_correlation:+.2f}"
        shown.append(f"{name} {text}" if abs(each.rank_correlation) > each.chance else f"{name} ({text})")
    return ", ".join(shown) or "-"
