"""Record what a run of scripts/sanitize.sh found: commit, date, sanitizer, tests that passed, findings.

    python scripts/sanitizer_result.py thread tests.xml --findings 0 -o benchmarks/results/sanitizers.json

The results of other sanitizers in the file stay. Once it is there, scripts/readme_tables.py makes the table
`sanitizers` of it.
"""

from __future__ import annotations

import argparse
import json
import subprocess
import sys
from datetime import UTC, datetime
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT / "benchmarks"))

from measure import Bound, write_results  # noqa: E402

OUTCOMES = ("failures", "errors", "skipped")


def counted(junit: Path) -> dict[str, int]:
    """How many tests passed, failed and were skipped, by pytest's report.

    Args:
        junit: the report, of pytest's option --junitxml.
    """
    suites = list(ElementTree.parse(junit).getroot().iter("testsuite"))  # noqa: S314 - pytest's own file
    of = {key: sum(int(suite.get(key, 0)) for suite in suites) for key in ("tests", *OUTCOMES)}
    failed = of["failures"] + of["errors"]
    return {"passed": of["tests"] - failed - of["skipped"], "failed": failed, "skipped": of["skipped"]}


def commit() -> str:
    """The commit that was built, with a plus sign if files were changed since; ``unknown`` without a repository."""
    words = ["git", "-C", str(ROOT), "describe", "--always", "--exclude=*", "--dirty=+"]
    return subprocess.run(words, capture_output=True, text=True, check=False).stdout.strip() or "unknown"


def main() -> int:
    """Add the run to the file."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("sanitizer", help="as scripts/sanitize.sh takes it")
    parser.add_argument("junit", type=Path, help="pytest's report")
    parser.add_argument("--findings", type=int, required=True, help="reports of the sanitizer")
    parser.add_argument("-o", "--output", type=Path, required=True)
    given = parser.parse_args()
    rows: list[dict[str, Any]] = []
    if given.output.is_file():
        rows = json.loads(given.output.read_text(encoding="utf-8"))["runs"]
    row = {"sanitizer": given.sanitizer, "commit": commit(), "date": datetime.now(UTC).date().isoformat()}
    row |= counted(given.junit) | {"findings": given.findings}
    rows = sorted([each for each in rows if each["sanitizer"] != given.sanitizer] + [row], key=lambda r: r["sanitizer"])
    bounds = [Bound(f"findings of {each['sanitizer']}", each["findings"], 0).to_dict() for each in rows]
    bounds += [Bound(f"tests that failed with {each['sanitizer']}", each["failed"], 0).to_dict() for each in rows]
    write_results(given.output, "scripts/sanitize.sh all", {"bounds": bounds, "runs": rows})
    return 0


if __name__ == "__main__":
    sys.exit(main())
