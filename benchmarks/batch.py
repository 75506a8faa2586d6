"""Thousands of runs: flexdyn beside mujoco.rollout, over threads, over the number of runs; a plan for a million.

    python benchmarks/batch.py [-o FILE.json] [--runs N] [--sample N] [--study N [N ...]]

Every slice of the runs is done by all contestants in turn, the order turning; flexdyn's solver is the cheapest of a
grid that comes as close to the event-driven reference as MuJoCo does, on runs of the same batch. Exit code 1 if one of
the bounds at the end does not hold.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
from arms import Array
from batch_contestants import STEP, Flexdyn, Rollout
from batch_plan import constants, plan
from batch_problem import Batch
from batch_study import measured
from measure import Bound, arguments, conclude
from mujoco_arm import SETTINGS
from result_tables import markdown_table

import flexdyn as fd

THREADS = 2
SLICE = 500  # runs
PAIRS = 6  # studies on one thread and on two, in turn: the fastest of each is the one least disturbed
REFERENCE = fd.solvers.DormandPrince(rtol=1e-10, atol=1e-12)
SETTINGS_TRIED: tuple[fd.solvers.Solver, ...] = (
    *(fd.solvers.TimeStepping(step=step) for step in (1e-2, 3e-3, 1e-3)),
    *(fd.solvers.Rosenbrock(rtol=rtol, atol=0.1 * rtol) for rtol in (1e-2, 3e-3, 1e-3, 3e-4)),
    *(fd.solvers.DormandPrince(rtol=rtol, atol=0.1 * rtol) for rtol in (1e-2, 3e-3, 1e-3, 5e-4, 2e-4, 1e-4)),
)
BATCHES = {
    "states": Batch("first states differ", 10_000),
    "numbers": Batch("first states, stiffness, rotors and friction differ", 10_000, numbers=True),
    "log": Batch("first states differ, torque held at 100 Hz", 2_000, log=True),
}


def error(positions: Array, truth: Array) -> dict[str, float]:
    """Distance from the reference over all samples of rotors and links [rad]."""
    distance = np.abs(positions - truth)
    return {"rms": _short(np.sqrt((distance**2).mean())), "worst": _short(distance.max())}


def chosen(batch: Batch, sample: range) -> tuple[fd.solvers.Solver, dict[str, Any]]:
    """The cheapest setting that is as close to the reference as MuJoCo's harder friction is, rms and worst.

    Raises:
        RuntimeError: there is none.
    """
    truth = Flexdyn(batch, REFERENCE, 1).positions(sample)
    found = {
        f"MuJoCo Euler, {friction} friction": error(
            Rollout(batch, 1, len(sample), hard=friction == "hardest").positions(sample), truth
        )
        for friction in ("default", "hardest")
    }
    goal = found["MuJoCo Euler, hardest friction"]
    best: tuple[float, fd.solvers.Solver] | None = None
    for solver in SETTINGS_TRIED:
        contestant = Flexdyn(batch, solver, 1)
        each = error(contestant.positions(sample), truth)
        cost = min(contestant.processor_seconds(sample) for _ in range(3)) / len(sample)
        found[str(solver)] = each | {"microseconds": _short(1e6 * cost)}
        good = all(each[key] <= goal[key] for key in goal)
        if good and (best is None or cost < best[0]):
            best = cost, solver
    if best is None:
        raise RuntimeError(f"{batch.title}: no setting reaches {goal}")
    return best[1], found


def race(batch: Batch, solver: fd.solvers.Solver, runs: int) -> dict[str, Any]:
    """All runs by everybody, slice by slice: runs per second and their ratios, medians over the slices."""
    ours = {threads: Flexdyn(batch, solver, threads) for threads in (1, THREADS)}
    peers = {hard: Rollout(batch, THREADS, SLICE, hard=hard) for hard in (False, True)}
    work: dict[str, Callable[[range], None]] = {
        "flexdyn": ours[THREADS].run,
        "flexdyn, one thread": ours[1].run,
        "mujoco.rollout": peers[False].run,
        "mujoco.rollout, hardest friction": peers[True].run,
    }
    names = list(work)
    seconds: dict[str, list[float]] = {name: [] for name in names}
    used: dict[str, list[float]] = {name: [] for name in names}
    for turn, first in enumerate(range(0, runs, SLICE)):
        which = range(first, min(first + SLICE, runs))
        for peer in peers.values():
            peer.prepare(which)
        for name in (*names[turn % len(names) :], *names[: turn % len(names)]):
            begin, before = time.perf_counter(), time.process_time()
            work[name](which)
            seconds[name].append((time.perf_counter() - begin) / len(which))
            used[name].append((time.process_time() - before) / len(which))
    wall = {name: np.array(column) for name, column in seconds.items()}
    return {
        "runs": runs,
        "contestants": {
            name: {
                "runs_per_second": _short(1.0 / float(np.median(wall[name]))),
                "processor_microseconds": _short(1e6 * float(np.median(used[name]))),
            }
            for name in names
        },
        "over_rollout": _short(float(np.median(wall["mujoco.rollout"] / wall["flexdyn"]))),
        "over_hard_rollout": _short(float(np.median(wall["mujoco.rollout, hardest friction"] / wall["flexdyn"]))),
        "of_one_thread": _short(float(np.median(wall["flexdyn, one thread"] / wall["flexdyn"]))),
    }


def studies(batch: Batch, solver: fd.solvers.Solver, counts: Sequence[int], sample: range) -> dict[str, Any]:
    """The batch as a study: cost and memory over the number of runs, threads, and what it costs besides integrating."""
    some = counts[len(counts) // 2]
    turns = [(1, THREADS) if turn % 2 == 0 else (THREADS, 1) for turn in range(PAIRS)]
    with TemporaryDirectory() as folder:
        study = partial(measured, Path(folder), batch, solver.to_dict())
        grown = [study(runs, THREADS, numbers=True) for runs in counts]
        trials = [(threads, study(some, threads, numbers=False)) for turn in turns for threads in turn]
    least = {count: min(each.seconds for threads, each in trials if threads == count) for count in (1, THREADS)}
    bare = min(Flexdyn(batch, solver, 1).bare_seconds(sample) for _ in range(5)) / len(sample)
    whole = min(each.processor_seconds / each.runs for threads, each in trials if threads == 1)
    return {
        "by_runs": [each.to_dict() for each in grown],
        "of_one_thread": _short(least[1] / least[THREADS]),
        "integration_microseconds": _short(1e6 * bare),
        "overhead_microseconds": _short(1e6 * (whole - bare)),
    }


def tables(results: Mapping[str, Any]) -> str:
    """Markdown of what was measured."""
    header = ["2 s of the two-link arm", "flexdyn [runs/s]", "mujoco.rollout [runs/s]", "ratio", "two threads of one"]
    header += ["flexdyn: rms, worst error [rad]", "MuJoCo: rms, worst error [rad]"]
    rows = []
    for each in results["batches"].values():
        speed, errors = each["race"]["contestants"], each["errors"]
        ours, theirs = errors[each["solver"]], errors["MuJoCo Euler, hardest friction"]
        rows.append(
            [
                each["title"],
                f"{speed['flexdyn']['runs_per_second']:,.0f}",
                f"{speed['mujoco.rollout']['runs_per_second']:,.0f}",
                f"{each['race']['over_rollout']:.1f}",
                f"{each['race']['of_one_thread']:.2f}",
                *(f"{found['rms']:.1e}, {found['worst']:.1e}" for found in (ours, theirs)),
            ]
        )
    grown = [
        [
            f"{each['runs']:,.0f}",
            *(f"{each[key]:.4g}" for key in ("microseconds_per_run", "peak_megabytes", "store_megabytes")),
        ]
        for each in results["study"]["by_runs"]
    ]
    columns = ["runs of a study", "time of a run [us]", "peak memory [MB]", "store [MB]"]
    return "\n\n".join((markdown_table(header, rows), markdown_table(columns, grown, text=0)))


def bounds(results: Mapping[str, Any]) -> list[Bound]:
    """What flexdyn promises."""
    found = []
    for each in results["batches"].values():
        title = each["title"]
        found.append(Bound(f"{title}: time / mujoco.rollout's", 1.0 / each["race"]["over_rollout"], 1.0 / 3.0))
    study = results["study"]
    grown = study["by_runs"]
    found.append(Bound("study, two threads: time / one thread's", 1.0 / study["of_one_thread"], 1.0 / 1.8))
    growth = grown[-1]["peak_megabytes"] - grown[-2]["peak_megabytes"]
    found.append(Bound(f"memory of {grown[-1]['runs']:,} runs less {grown[-2]['runs']:,} [MB]", growth, 10.0))
    rise = grown[-1]["microseconds_per_run"] / grown[-2]["microseconds_per_run"]
    found.append(Bound(f"cost of a run, {grown[-1]['runs']:,} runs / {grown[-2]['runs']:,}", rise, 1.2))
    return found


def main() -> int:
    """Measure, print, write; 1 if a bound does not hold."""
    parser = arguments(__doc__)
    parser.add_argument("--runs", type=int, help="of every race; default: 10,000, and 2,000 of the log")
    parser.add_argument("--sample", type=int, default=200, help="runs whose errors are looked at")
    parser.add_argument("--study", type=int, nargs="+", default=[1_000, 10_000, 100_000], help="runs of the studies")
    options = parser.parse_args()
    results: dict[str, Any] = {
        "threads": THREADS,
        "mujoco_step": STEP,
        "mujoco_settings": SETTINGS["dry"],
        "batches": {},
    }
    for name, batch in BATCHES.items():
        solver, errors = chosen(batch, range(options.sample))
        raced = race(batch, solver, min(options.runs or batch.runs, batch.runs))
        results["batches"][name] = {"title": batch.title, "solver": str(solver), "errors": errors, "race": raced}
        if name == "states":
            results["study"] = studies(batch, solver, options.study, range(options.sample))
    results["constants"] = constants(results["study"]["by_runs"][-1], results["study"])
    results["plan"] = plan(results["constants"])
    held = bounds(results)
    print(tables(results), end="\n\n")
    print("\n".join(results["plan"]), end="\n\n")
    return conclude(held, options.output, "python benchmarks/batch.py", results)


def _short(number: float) -> float:
    return float(f"{number:.4g}")


if __name__ == "__main__":
    sys.exit(main())
