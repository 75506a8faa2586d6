"""How much of each package the tests run, as the table of CONTRIBUTING.md.

    pytest -n 2 --dist loadfile --cov --cov-report=json:build/coverage.json
    python scripts/coverage_table.py build/coverage.json

Lines that run only in processes which tests start by themselves are not counted.
"""

from __future__ import annotations

import json
import sys
from collections.abc import Mapping
from pathlib import Path, PurePosixPath
from typing import Any


def table(files: Mapping[str, Any]) -> str:
    """Statements and the share of them that ran, by package; then the modules of which none ran beyond the head.

    Args:
        files: of coverage's JSON report, by path.
    """
    counts: dict[str, list[int]] = {}
    for path, found in files.items():
        parts = PurePosixPath(path).parts
        package = parts[parts.index("flexdyn") + 1] if len(parts) - parts.index("flexdyn") > 2 else "its root"
        for name in (package, "all"):
            both = counts.setdefault(name, [0, 0])
            both[0] += found["summary"]["num_statements"]
            both[1] += found["summary"]["covered_lines"]
    rows = [f"| {name} | {count:,} | {ran / count:.1%} |" for name, (count, ran) in sorted(counts.items()) if count]
    untouched = [path for path, found in files.items() if not _touched(found)]
    told = "Modules of which no function ran: " + (", ".join(untouched) or "none") + "."
    return "\n".join(["| package | statements | run |", "| --- | ---: | ---: |", *rows, "", told])


def _touched(found: Mapping[str, Any]) -> bool:
    """Whether a statement inside a function ran; where there is no function, any statement."""
    functions = [each for name, each in found.get("functions", {}).items() if name]
    return (
        any(each["summary"]["covered_lines"] for each in functions or [found]) or not found["summary"]["num_statements"]
    )


if __name__ == "__main__":
    print(table(json.loads(Path(sys.argv[1]).read_text(encoding="utf-8"))["files"]))
