"""Record the coverage of the tests at one commit: statements by package, and how many tests ran.

    pytest --cov --cov-report=json:build/coverage.json
    python scripts/coverage_result.py COMMIT build/coverage.json --passed N --failed N -o RESULTS

The numbers of tests stand in the last line of pytest. Runs of other commits in the file stay.
scripts/readme_tables.py makes the table `coverage` of benchmarks/results/coverage.json.
"""

from __future__ import annotations

import argparse
import json
import sys
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[1]
sys.path[:0] = [str(ROOT / "benchmarks"), str(ROOT / "scripts")]

from coverage_table import counts  # noqa: E402
from measure import write_results  # noqa: E402


def main() -> int:
    """Add the run to the file."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("commit")
    parser.add_argument("coverage", type=Path, help="coverage's JSON report")
    parser.add_argument("--passed", type=int, required=True, help="tests that passed")
    parser.add_argument("--failed", type=int, required=True, help="tests that failed")
    parser.add_argument("-o", "--output", type=Path, required=True)
    given = parser.parse_args()
    runs: list[dict[str, Any]] = []
    if given.output.is_file():
        runs = json.loads(given.output.read_text(encoding="utf-8"))["runs"]
    packages = counts(json.loads(given.coverage.read_text(encoding="utf-8"))["files"])
    row = {"commit": given.commit, "passed": given.passed, "failed": given.failed, "packages": packages}
    runs = [each for each in runs if each["commit"] != given.commit] + [row]
    write_results(given.output, "scripts/coverage_result.py COMMIT COVERAGE --passed N --failed N", {"runs": runs})
    return 0


if __name__ == "__main__":
    sys.exit(main())
