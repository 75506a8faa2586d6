"""Does every run come to an end, and do the solvers agree? Models drawn at random through every solver.

    python benchmarks/random_runs.py [--count 400] [--extreme 82] [-o FILE.json]

Prints how many runs ended, how many spent their budget of steps, whether the solver that the error proposes ended, and
how far DormandPrince and Rosenbrock, and TimeStepping and Rosenbrock, are from each other where both ended. RungeKutta4
takes equal steps, and smooths dry friction, without which it would refuse it; on a stiff arm it stops and says so. Exit
code 1 if a run took longer than any budget allows, if one said nothing of where it stood, if a proposal did not end, or
if RungeKutta4 stopped without the remedy of a smaller step.
"""

from __future__ import annotations

import sys
import time
import warnings
from dataclasses import dataclass
from typing import Any

import numpy as np
from measure import Bound, arguments, conclude
from random_models import Array, Problem, drawn
from trust_tables import random_runs_table

import flexdyn as fd

EQUAL_STEPS = fd.solvers.RungeKutta4(step=1e-4, smoothing=1e-3)
SOLVERS: tuple[Any, ...] = (
    "auto",
    fd.solvers.DormandPrince(),
    fd.solvers.Rosenbrock(),
    fd.solvers.TimeStepping(),
    EQUAL_STEPS,
)
LONGEST = 120.0  # s of CPU: any budget is spent by then


@dataclass(frozen=True)
class Outcome:
    """What became of a run.

    Attributes:
        seconds: of CPU.
        q: positions at its samples; None: it stopped.
        error: why it stopped, or nothing.
    """

    seconds: float
    q: Array | None
    error: fd.SimulationError | None
    solver: str


def name_of(solver: Any) -> str:
    """As the tables show it."""
    return solver if isinstance(solver, str) else type(solver).__name__


def outcome(problem: Problem, solver: Any) -> Outcome:
    """Make the run."""
    begin = time.process_time()
    try:
        run = problem.run(solver, rate=100.0)
    except fd.SimulationError as error:
        return Outcome(time.process_time() - begin, None, error, name_of(solver))
    return Outcome(time.process_time() - begin, run.q, None, type(run.solver).__name__)


def apart(one: Array, other: Array) -> float:
    """Greatest difference of two motions, of the size of the motion."""
    return float(np.abs(one - other).max() / max(1e-3, np.abs(one - one[0]).max()))


def survey(count: int, *, extreme: bool) -> dict[str, Any]:
    """All solvers on models of the seeds 0 to count - 1."""
    rows: dict[str, dict[str, Any]] = {}
    for solver in SOLVERS:
        keys = ("models", "ended", "budget spent", "other error", "rescued")
        rows[name_of(solver)] = dict.fromkeys((*keys, "silent", "switched", "smaller step"), 0) | {"seconds": 0.0}
    differ: list[tuple[int, float]] = []
    fixed: list[float] = []
    for seed in range(count):
        problem = drawn(seed, extreme=extreme)
        found = {name_of(solver): outcome(problem, solver) for solver in SOLVERS}
        for name, each in found.items():
            _enter(rows[name], each, found)
            if each.error is not None:
                print(f"{'extreme ' if extreme else ''}{seed}: {each.error}", file=sys.stderr, flush=True)
        one, other = found["DormandPrince"].q, found["Rosenbrock"].q
        if one is not None and other is not None:
            differ.append((seed, apart(one, other)))
        if found["TimeStepping"].q is not None and other is not None:
            fixed.append(apart(found["TimeStepping"].q, other))
    differ.sort(key=lambda pair: -pair[1])
    return {"rows": rows, "differ": differ, "fixed_step": [float(part) for part in np.percentile(fixed, [50, 90])]}


def _enter(row: dict[str, Any], each: Outcome, found: dict[str, Outcome]) -> None:
    row["models"] += 1
    row["seconds"] = max(row["seconds"], each.seconds)
    row["switched"] += each.solver == "DormandPrinceThenRosenbrock"
    if each.error is None:
        row["ended"] += 1
        return
    spent = each.error.reason == "more steps than allowed"
    row["budget spent" if spent else "other error"] += 1
    row["silent"] += spent and each.error.fastest is None
    row["smaller step"] += "take a smaller step" in each.error.remedy
    # A remedy may name a second solver, for the case that the first one stops as well.
    proposed = [name for name in found if f"take {name}" in each.error.remedy]
    row["rescued"] += any(found[name].error is None for name in proposed)


def main() -> int:
    """Survey, print, write."""
    parser = arguments(__doc__)
    parser.add_argument("--count", type=int, default=400, help="ordinary models")
    parser.add_argument("--extreme", type=int, default=82, help="extreme models")
    args = parser.parse_args()
    warnings.simplefilter("ignore")  # limits of robots, which these have none of
    surveys = (("ordinary", args.count), ("extreme", args.extreme))
    results = {name: survey(count, extreme=name == "extreme") for name, count in surveys if count}
    print(random_runs_table({"surveys": results}))
    every = [row for found in results.values() for row in found["rows"].values()]
    stopped = [row["models"] - row["ended"] for row in every]
    equal = [name == name_of(EQUAL_STEPS) for found in results.values() for name in found["rows"]]
    lost = sum(n - row["rescued"] for n, row, it_is in zip(stopped, every, equal, strict=True) if not it_is)
    unsaid = sum(n - row["smaller step"] for n, row, it_is in zip(stopped, every, equal, strict=True) if it_is)
    bounds = [
        Bound("longest run, s of CPU", max(row["seconds"] for row in every), LONGEST),
        Bound("budgets spent without a word on the fastest motion", sum(row["silent"] for row in every), 0),
        Bound("stopped runs of which no proposed solver ended", lost, 0),
        Bound("stops of RungeKutta4 that do not say to take a smaller step", unsaid, 0),
    ]
    command = f"python benchmarks/random_runs.py --count {args.count} --extreme {args.extreme}"
    return conclude(bounds, args.output, command, {"surveys": results})


if __name__ == "__main__":
    sys.exit(main())
