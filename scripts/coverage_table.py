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


def counts(files: Mapping[str, Any]) -> dict[str, list[int]]:
    """Statements and those of them that ran, by package and of ``all``.

    Args:
        files: of coverage's JSON report, by path.
    """
    found: dict[str, list[int]] = {}
    for path, of_file in files.items():
        parts = PurePosixPath(path).parts
        start = len(parts) - 1 - parts[::-1].index("flexdyn")
        package = parts[start + 1] if len(parts) - start > 2 else "its root"
        for name in (package, "all"):
            both = found.setdefault(name, [0, 0])
            both[0] += of_file["summary"]["num_statements"]
            both[1] += of_file["summary"]["covered_lines"]
    return {name: both for name, both in sorted(found.items()) if both[0]}


def table(files: Mapping[str, Any]) -> str:
    """Statements and the share of them that ran, by package; then the modules of which none ran beyond the head."""
    rows = [f"| {name} | {count:,} | {ran / count:.1%} |" for name, (count, ran) in counts(files).items()]
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
