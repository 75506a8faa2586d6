"""The same diagnosis at the full, half and a tenth of the sampling rate: which names stay.

    python benchmarks/measured/rates.py -o benchmarks/results/rates.json

Recordings are decimated by `Recording.decimate`: positions behind a filter, what is held as means. Nothing folds down,
and nothing moves in time. One robot after the other, in one process; times are processor time. `--only NAME` makes one
robot anew and keeps the others of the result file. Without the data folder it says so and does nothing.
"""

from __future__ import annotations

import argparse
import json
import sys
import time
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np

HERE = Path(__file__).resolve().parent
sys.path += [str(HERE), str(HERE.parent), *(str(each) for each in sorted(HERE.iterdir()) if each.is_dir())]
import damper_study  # noqa: E402
import emps_study  # noqa: E402
import kinova_study  # noqa: E402
import kuka_study  # noqa: E402
import pendulum_study  # noqa: E402
import screw_study  # noqa: E402
import xl330_study  # noqa: E402
from measure import write_results  # noqa: E402
from task import Task  # noqa: E402

from flexdyn.diagnose import Suspect  # noqa: E402
from flexdyn.errors import InputError  # noqa: E402

FACTORS = (1, 2, 10)
ROBOTS: Mapping[str, tuple[str, Callable[[Path], list[Task]]]] = {
    "emps": ("emps", emps_study.tasks),
    "double_pendulum": ("dfki_double_pendulum", pendulum_study.tasks),
    "kuka_kr300": ("kuka_kr300", kuka_study.tasks),
    "xl330": ("bam_xl330", xl330_study.tasks),
    "friction_damper": ("arts_damper", damper_study.tasks),
    "kinova_gen3": ("kinova_gen3", kinova_study.tasks),
}
"""Folder of the data, and what is diagnosed of them; screw drives have curves of steady friction instead."""
SCREWS = "screw_drives"


def of_task(task: Task) -> dict[str, Any]:
    """A diagnosis at each rate."""
    return {"what": task.name, "at": [_diagnosed(task, factor) for factor in FACTORS]}


def _diagnosed(task: Task, factor: int) -> dict[str, Any]:
    begin = time.process_time()
    row: dict[str, Any] = {"factor": factor, "rate": task.rate / factor}
    try:
        slower = task if factor == 1 else task.decimated(factor)
        row["seconds_read"] = sum(each.duration for each in slower.fit)
        found = slower.diagnosis()
    except InputError as error:
        return row | {"refused": str(error), "names": []}
    names = [
        {
            "names": list(dict.fromkeys(_name(each) for each in finding.names)),
            "probability": finding.probability,
        }
        for finding in found.findings
    ]
    gap = None if found.gap_test is None else [found.gap_test.before, found.gap_test.after]
    spent = time.process_time() - begin
    return row | {"verdict": found.verdict, "names": names, "gap": gap, "processor_seconds": spent}


def _name(suspect: Suspect) -> str:
    """An effect and where it acts; of a wrong number, whose and which."""
    if suspect.effect == "parameter_error":
        return f"wrong {suspect.place['parameter']} ({suspect.place['of']})"
    return suspect.effect if suspect.joint is None else f"{suspect.effect} ({suspect.joint})"


def of_screws(folder: Path) -> Iterator[dict[str, Any]]:
    """Curves of steady friction at each rate."""
    for drive in screw_study.DRIVES:
        rows = []
        for factor in FACTORS:
            begin = time.process_time()
            made = screw_study.studied(folder, drive, factor)
            names = [
                {"names": [f"{name} ({way:+d})"], "probability": None}
                for way, curve in made.curves.items()
                for name in curve.named
            ]
            rate = float(np.median([each.rate for each in screw_study.read_runs(folder, drive)])) / factor
            spent = time.process_time() - begin
            rows.append({"factor": factor, "rate": rate, "names": names, "processor_seconds": spent})
        yield {"what": drive.words, "at": rows}


def main() -> int:
    """All robots whose data are there, or one of them."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("-o", type=Path, required=True, help="the result file")
    parser.add_argument("--data", type=Path, default=Path("../shared/data"), help="folder of the measured data")
    parser.add_argument("--only", choices=[*ROBOTS, SCREWS], help="one robot; the others stay as the file has them")
    options = parser.parse_args()
    known = json.loads(options.o.read_text(encoding="utf-8"))["robots"] if options.only and options.o.is_file() else {}
    for robot in [options.only] if options.only else [*ROBOTS, SCREWS]:
        folder = options.data / (SCREWS if robot == SCREWS else ROBOTS[robot][0])
        if not folder.is_dir():
            print(f"skipped: {folder} is not there (--data)")
            continue
        made = of_screws(folder) if robot == SCREWS else (of_task(each) for each in ROBOTS[robot][1](folder))
        known[robot] = []
        for each in made:
            known[robot].append(each)
            print(each["what"], *((row["factor"], [name["names"] for name in row["names"]]) for row in each["at"]))
        write_results(options.o, "python benchmarks/measured/rates.py", {"robots": known})
    return 0


if __name__ == "__main__":
    sys.exit(main())
