"""Compare the results of the same benchmarks at two commits, number by number and word by word.

    python benchmarks/same_results.py BEFORE AFTER COMMIT COMMIT -o benchmarks/results/same_results.json

BEFORE and AFTER are folders of JSON files that the benchmarks wrote. Times, memory, dates and versions take no part.
"""

from __future__ import annotations

import json
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from measure import Bound, arguments, conclude
from result_tables import markdown_table

OF_THE_MACHINE = {"date", "versions", "processor", "ratio", "quartiles", "cost_in_aba_calls", "memory_mb"}
"""Keys of what depends on the day and the machine; those with ``second`` in their name do as well."""


def leaves(content: Any, place: str = "") -> Iterator[tuple[str, Any]]:
    """Every number and word of a result with its place, but those of the machine."""
    if isinstance(content, dict):
        for key, value in content.items():
            if key not in OF_THE_MACHINE and "second" not in key:
                yield from leaves(value, f"{place}/{key}")
    elif isinstance(content, list):
        for k, value in enumerate(content):
            yield from leaves(value, f"{place}/{k}")
    else:
        yield place, content


def compared(before: Path, after: Path) -> dict[str, dict[str, Any]]:
    """For each benchmark: how many values there are, and the places of those that differ or are missing.

    Args:
        before: a folder of result files; those in a folder of their own count as one benchmark.
        after: likewise, from the other commit.
    """
    found: dict[str, dict[str, Any]] = {}
    files = {path.relative_to(folder) for folder in (before, after) for path in folder.rglob("*.json")}
    for file in sorted(files):
        one, other = (_content(folder / file) for folder in (before, after))
        places = one.keys() | other.keys()
        missing = object()
        row = found.setdefault(file.with_suffix("").parts[0], {"values": 0, "different": []})
        row["values"] += len(places)
        row["different"] += [f"{file}{p}" for p in sorted(places) if one.get(p, missing) != other.get(p, missing)]
    return found


def _content(file: Path) -> dict[str, Any]:
    return dict(leaves(json.loads(file.read_text(encoding="utf-8")))) if file.is_file() else {}


def same_results_table(results: dict[str, Any]) -> str:
    """How many values of each benchmark were compared, and how many differ."""
    rows = [
        [f"`{name}`", f"{row['values']:,}", f"{len(row['different']):,}"] for name, row in results["benchmarks"].items()
    ]
    return markdown_table([f"benchmark, {' and '.join(results['commits'])}", "values", "different"], rows)


def main() -> int:
    """Compare, print and write."""
    parser = arguments(__doc__)
    parser.add_argument("before", type=Path)
    parser.add_argument("after", type=Path)
    parser.add_argument("commits", nargs=2)
    given = parser.parse_args()
    found = compared(given.before, given.after)
    bounds = [Bound(f"values of {name} that differ", len(row["different"]), 0) for name, row in found.items()]
    command = f"same_results.py BEFORE AFTER {' '.join(given.commits)}"
    return conclude(bounds, given.output, command, {"commits": given.commits, "benchmarks": found})


if __name__ == "__main__":
    sys.exit(main())
