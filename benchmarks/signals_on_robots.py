"""Measured robots, diagnosed with the noise estimator and the smoother for users in place of the diagnosis' own.

    python benchmarks/signals_on_robots.py DATA -o benchmarks/results/signals_on_robots.json

DATA is the folder of the measured robots' data. See signals_in_diagnosis.py for the variants.
"""

from __future__ import annotations

import importlib
import sys
from pathlib import Path
from typing import Any

from measure import arguments, conclude
from signals_in_diagnosis import VARIANTS, variant

ROBOTS = {
    "EMPS": ("emps", "emps_study", "emps"),
    "double pendulum": ("double_pendulum", "pendulum_study", "dfki_double_pendulum"),
}
"""Robot -> folder of its study, module, folder of its data. Those whose diagnosis takes seconds."""
HERE = Path(__file__).parent / "measured"


def names(robot: str, data: Path) -> dict[str, dict[str, Any]]:
    """What each variant names, and the verdict, by the study's tasks."""
    folder, module, files = ROBOTS[robot]
    sys.path[:0] = [str(HERE), str(HERE / folder)]
    tasks = importlib.import_module(module).tasks(data / files)
    found: dict[str, dict[str, Any]] = {}
    for name in VARIANTS:
        with variant(name):
            answers = [task.diagnosis() for task in tasks]
        found[name] = {
            "verdict": [each.verdict for each in answers],
            "names": [
                f"{f.suspect.effect}@{f.suspect.joint or f.suspect.place}" for each in answers for f in each.findings
            ],
            "gap": [None if each.gap_test is None else each.gap_test.after for each in answers],
        }
    return found


def main() -> int:
    """Diagnose, print and write."""
    parser = arguments(__doc__)
    parser.add_argument("data", type=Path)
    given = parser.parse_args()
    robots = {robot: names(robot, given.data) for robot in ROBOTS}
    for robot, found in robots.items():
        print(robot, *(f"{name}: {each}" for name, each in found.items()), sep="\n  ")
    return conclude([], given.output, "signals_on_robots.py DATA", {"robots": robots})


if __name__ == "__main__":
    sys.exit(main())
