"""Hidden-effect cases end to end: make them, diagnose each in a process of its own, then read the truth and score.

    python benchmarks/discovery/run.py --family single hard --seed 3 --count 20 -o DIR

DIR/<family> and DIR/<family>.truth hold the cases, DIR/<family>.reports what the diagnosis wrote, DIR/result.json the
scores. What is there already is not made or diagnosed again; --only-score does neither.
"""

from __future__ import annotations

import argparse
import json
import resource
import subprocess
import sys
from pathlib import Path
from typing import Any

from cases import CHECK, FAMILIES, FIT, sensors_of
from make import ALL, build, ending, write_case
from overview import content_of, line, tables
from score import read, score, score_folder

LIMIT = 600.0  # s per case: a diagnosis that takes longer has failed


def diagnose(folder: Path, output: Path) -> dict[str, Any]:
    """Run the program as a user does; what it cost."""
    program = str(Path(sys.executable).with_name("flexdyn"))
    command = [program, "diagnose", "model.yaml", "fit.npz", "--check", "check.npz", "-o", str(output.resolve())]
    output.mkdir(parents=True, exist_ok=True)
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    try:
        done = subprocess.run(command, cwd=folder, capture_output=True, text=True, timeout=LIMIT, check=False)
        code, errors = done.returncode, done.stderr[-2000:]
    except subprocess.TimeoutExpired:
        code, errors = -1, f"stopped after {LIMIT:g} s"
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    # Processor time: the wall clock would tell what else the machine was doing.
    seconds = after.ru_utime - before.ru_utime + after.ru_stime - before.ru_stime
    cost = {"seconds": seconds, "exit": code, "stderr": errors if code else ""}
    (output / "cost.json").write_text(json.dumps(cost) + "\n", encoding="utf-8")
    return cost


def run_family(family: str, seed: int, numbers: range, durations: tuple[float, float], place: Path) -> None:
    """Make and diagnose what is not there yet."""
    for number in numbers:
        name = f"{family}_{seed}_{number:03d}"
        folder, output = place / family / name, place / f"{family}.reports" / name
        if not (folder / "check.npz").exists():
            write_case(build(family, seed, number, *durations, sensors_of(family)), place / family)
        if not (output / "cost.json").exists():
            cost = diagnose(folder, output)
            truth = read(place / f"{family}.truth" / f"{name}.json")
            said = line(score(truth, read(output / "report.json"))) if truth else name
            print(f"{said} [exit {cost['exit']}, {cost['seconds']:.0f} s]", file=sys.stderr, flush=True)


def main() -> int:
    """Make, diagnose, score, print, write."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n")[0])
    parser.add_argument("--family", nargs="+", choices=ALL, default=list(FAMILIES))
    parser.add_argument("--seed", type=int, default=0, help="from 10000 on: evaluation, not to be looked at before")
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--count", type=int, default=20)
    parser.add_argument("--fit", type=float, default=FIT, help="[s]")
    parser.add_argument("--check", type=float, default=CHECK, help="[s]")
    parser.add_argument("--wide", action="store_true", help="draw from wider ranges (wide.py); the family is called so")
    parser.add_argument("--only-score", action="store_true")
    parser.add_argument("-o", "--output", type=Path, required=True)
    o = parser.parse_args()
    rows: list[dict[str, Any]] = []
    for family in (ending(each, o.wide) for each in o.family):
        if not o.only_score:
            run_family(family, o.seed, range(o.first, o.first + o.count), (o.fit, o.check), o.output)
        rows += score_folder(o.output / family, o.output / f"{family}.reports")
    print(tables(rows))
    memory = resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss / 1024
    print(f"greatest memory of a diagnosis: {memory:.0f} MB")
    content = {"seed": o.seed, "memory_mb": memory, **content_of(rows)}
    (o.output / "result.json").write_text(json.dumps(content, indent=1) + "\n", encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
