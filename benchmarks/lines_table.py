"""The table of lines of code by package at two commits, which `scripts/lines.py` counts."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

from result_tables import markdown_table

COUNTS = ("files", "lines", "code")


def lines_table(results: Mapping[str, Any]) -> str:
    """Files, lines and lines of code by package; sums of the package, and of all outside the tests."""
    both = [results[when]["packages"] for when in ("before", "now")]
    rows = [[f"`{name}`", *_cells(found.get(name) for found in both)] for name in sorted(set().union(*both))]
    for name, wanted in (("flexdyn", lambda each: each.startswith("flexdyn/")), ("all but tests", _is_no_test)):
        sums = [{key: sum(found[each][key] for each in filter(wanted, found)) for key in COUNTS} for found in both]
        rows.append([f"**{name}**", *_cells(sums)])
    heads = [f"{key}, {results[when]['commit']}" for when in ("before", "now") for key in ("files", "lines", "of code")]
    return markdown_table(["package", *heads], rows)


def _is_no_test(package: str) -> bool:
    return package != "tests/"


def _cells(counts: Iterable[Mapping[str, int] | None]) -> list[str]:
    return [f"{found[key]:,}" if found else "-" for found in counts for key in COUNTS]
