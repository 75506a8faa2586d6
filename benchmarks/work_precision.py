"""How much time does a given accuracy cost? Four arms; flexdyn's solvers, MuJoCo's integrators, SciPy over pin.aba.

    python benchmarks/work_precision.py [-o FILE.json] [--figures DIR] [--rounds N] [--case NAME]

The truth is the paper's equations written out by hand and integrated by SciPy from corner to corner. Every method runs
at all its steps or tolerances, all in turns; its curve is the least time at which it reaches an error. Exit code 1 if
an arm's truth is not known well enough.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Sequence
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
from measure import Array, Bound, arguments, conclude, race
from mujoco_arm import SETTINGS
from precision_cases import Case, Setting, cases, mujoco, ours, scipy
from precision_figure import draw
from result_tables import markdown_table

LEVELS = 10.0 ** -np.arange(3.0, 9.0)
GOAL = 0.1
SLOW = 0.1  # s: what takes longer is timed once, the noise of a short run is none of its trouble
USELESS = 0.3  # rad: an error above it says nothing


def measure(case: Case, rounds: int) -> dict[str, Any]:
    """Errors and times of everybody on one arm."""
    truth, corners = case.truth()
    again, _ = case.truth(max_step=2e-3)
    settings, errors, once = useful([*ours(case), *mujoco(case), *scipy(case)], truth)
    quick = [each for each, seconds in zip(settings, once, strict=True) if seconds < SLOW]
    times = race([each.contestant for each in quick], rounds)
    methods: dict[str, list[dict[str, float]]] = {}
    for each, error, seconds in zip(settings, errors, once, strict=True):
        column = times.get(each.contestant.name, np.array([seconds]))
        point = {"setting": each.value, "error_rad": error, "seconds": max(float(np.median(column)), 1e-6)}
        methods.setdefault(each.method, []).append({key: float(f"{value:.3g}") for key, value in point.items()})
    return {
        "title": case.title,
        "corners": corners,
        "truth_uncertainty_rad": float(f"{np.abs(again - truth).max():.2g}"),
        "methods": methods,
        "levels": compare(methods),
    }


def useful(settings: Sequence[Setting], truth: Array) -> tuple[list[Setting], list[float], list[float]]:
    """The settings that give an answer, the greatest error of each [rad] and its time [s]; who gives up is left out."""
    kept, errors, seconds = [], [], []
    for each in settings:
        begin = time.process_time()
        try:
            error = float(np.abs(each.positions() - truth).max())
        except RuntimeError:
            continue
        if np.isfinite(error) and error < USELESS:
            kept.append(each)
            errors.append(error)
            seconds.append(time.process_time() - begin)
    return kept, errors, seconds


def cost(points: Sequence[dict[str, float]], level: float) -> float:
    """The least time at which a method's error is at most so much; between two settings, on a straight log-log line."""
    ordered = sorted(points, key=lambda p: p["setting"])
    found = [p["seconds"] for p in ordered if p["error_rad"] <= level]
    for pair in pairwise(ordered):
        fine, coarse = sorted(pair, key=lambda p: p["error_rad"])
        if not fine["error_rad"] <= level < coarse["error_rad"]:
            continue
        share = np.log(level / coarse["error_rad"]) / np.log(fine["error_rad"] / coarse["error_rad"])
        found.append(float(coarse["seconds"] * (fine["seconds"] / coarse["seconds"]) ** share))
    return min(found, default=np.inf)


def compare(methods: dict[str, list[dict[str, float]]]) -> list[dict[str, Any]]:
    """The best of flexdyn and the best peer at every error level, and whether the goal is met."""
    rows = []
    for level in LEVELS:
        costs = {name: cost(points, float(level)) for name, points in methods.items()}
        best = {}
        for side, is_ours in (("ours", True), ("peer", False)):
            names = [name for name in costs if name.startswith("flexdyn") == is_ours and np.isfinite(costs[name])]
            best[side] = min(names, key=costs.__getitem__, default=None)
        ours_, peer = best["ours"], best["peer"]
        ratio = costs[ours_] / costs[peer] if ours_ and peer else None
        rows.append(
            {
                "error_rad": float(f"{level:.0e}"),
                "ours": ours_,
                "peer": peer,
                "milliseconds": [None if name is None else float(f"{costs[name] * 1e3:.3g}") for name in (ours_, peer)],
                "ratio": None if ratio is None else float(f"{ratio:.2g}"),
                "goal": bool(ours_ and (ratio is None or ratio <= GOAL)),
            }
        )
    return rows


def table(results: dict[str, Any]) -> str:
    """The best of ours and of the peers at every error level."""
    header = ["arm", "error [rad]", "flexdyn", "best peer", "flexdyn [ms]", "peer [ms]", "ratio", "a tenth?"]
    rows = []
    for case in results.values():
        for row in case["levels"]:
            short = [(row[side] or "none").replace("flexdyn ", "") for side in ("ours", "peer")]
            times = ["-" if value is None else f"{value:.3g}" for value in row["milliseconds"]]
            ratio = "-" if row["ratio"] is None else f"{row['ratio']:.2f}"
            rows.append(
                [case["title"], f"{row['error_rad']:.0e}", *short, *times, ratio, "yes" if row["goal"] else "NO"]
            )
    return markdown_table(header, rows, text=4)


def bounds(results: dict[str, Any]) -> list[Bound]:
    """A truth has to be known ten times better than the finest level it is held against."""
    return [
        Bound(f"{name}: uncertainty of the truth [rad]", case["truth_uncertainty_rad"], 0.1 * float(LEVELS[-1]))
        for name, case in results.items()
    ]


def main() -> int:
    """Measure, print, draw, write; 1 if a truth is not good enough."""
    parser = arguments(__doc__)
    parser.add_argument("--figures", type=Path, default=Path(__file__).parent / "figures", help="folder of the figures")
    parser.add_argument("--rounds", type=int, default=5, help="how often every setting is timed")
    parser.add_argument("--case", choices=[*cases()], help="this arm alone")
    options = parser.parse_args()
    chosen = {name: case for name, case in cases().items() if options.case in (None, name)}
    results = {}
    for name, case in chosen.items():
        results[name] = measure(case, options.rounds)
        draw(results[name], options.figures / f"work_precision_{name}.png")
    print(table(results), end="\n\n")
    held = bounds(results)
    met = [row["goal"] for case in results.values() for row in case["levels"]]
    print(f"a tenth of the best peer's time at {sum(met)} of {len(met)} error levels")
    content = {"goal": GOAL, "rounds": options.rounds, "mujoco_settings": SETTINGS, "cases": results}
    return conclude(held, options.output, "python benchmarks/work_precision.py", content)


if __name__ == "__main__":
    sys.exit(main())
