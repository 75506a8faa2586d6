"""The table of coverage by package at several commits, which `scripts/coverage_result.py` records."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from result_tables import markdown_table


def coverage_table(results: Mapping[str, Any]) -> str:
    """Statements, and the share of them that ran, by package; in the last row the tests."""
    runs = results["runs"]
    names = sorted(set().union(*(run["packages"] for run in runs)) - {"all"})
    rows = [[f"`{name}`", *_cells(runs, name)] for name in names]
    rows.append(["**all**", *_cells(runs, "all")])
    rows.append(["tests: passed, failed", *(f"{run[key]:,}" for run in runs for key in ("passed", "failed"))])
    heads = [f"{what}, {run['commit']}" for run in runs for what in ("statements", "run")]
    return markdown_table(["package", *heads], rows)


def _cells(runs: list[Mapping[str, Any]], name: str) -> list[str]:
    cells = []
    for run in runs:
        count, done = run["packages"].get(name, (0, 0))
        cells += [f"{count:,}", f"{done / count:.1%}"] if count else ["-", "-"]
    return cells
