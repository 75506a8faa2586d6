"""Does anything grow over an hour of simulated time, 10,000 models and 100,000 short runs?

    python benchmarks/long_runs.py [--share 1.0] [-o FILE.json]

The player's and the plot's page of that hour are made ten times besides. Every row is one kind of work in ten equal
parts: memory of the process after the second part (the first fills caches) and after the last, CPU time of a unit of
work in the second part and in the last. `--share 0.01` does a hundredth of the work. Linux only. Exit code 1 if memory
grows by more than the rows' own data, or if the last part is much slower.
"""

from __future__ import annotations

import gc
import os
import sys
import tempfile
import time
import warnings
from collections.abc import Callable
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np
from measure import Bound, arguments, conclude
from trust_tables import long_runs_table

import flexdyn as fd

PARTS = 10
GROWTH = 30.0  # MB: what an allocator may keep
SLOWER = 1.5  # times: what a busy machine makes of CPU time


@dataclass(frozen=True)
class Row:
    """One kind of work.

    Attributes:
        name: of the work.
        units: how many, and of what.
        memory: of the process after the second part and after the last [MB].
        cost: CPU time of a unit in these parts [s].
        kept: memory of what the work itself keeps [MB].
    """

    name: str
    units: str
    memory: tuple[float, float]
    cost: tuple[float, float]
    kept: float = 0.0

    @property
    def bounds(self) -> tuple[Bound, Bound]:
        """What must hold of it."""
        grown = self.memory[1] - self.memory[0] - self.kept
        return (
            Bound(f"{self.name}: memory grown, MB", grown, GROWTH),
            Bound(f"{self.name}: last part / second part", self.cost[1] / self.cost[0], SLOWER),
        )


def resident() -> float:
    """Memory of this process [MB]."""
    pages = int(Path("/proc/self/statm").read_text(encoding="ascii").split()[1])
    return pages * os.sysconf("SC_PAGE_SIZE") / 1e6


def repeated(name: str, unit: str, count: int, work: Callable[[int], None]) -> Row:
    """The work `count` times over, watched."""
    parts = min(PARTS, count)
    each = count // parts
    memory, cost = [], []
    for part in range(parts):
        begin = time.process_time()
        for k in range(each):
            work(part * each + k)
        cost.append((time.process_time() - begin) / each)
        gc.collect()
        memory.append(resident())
    return Row(name, f"{each * parts:,} {unit}", (memory[1], memory[-1]), (cost[1], cost[-1]))


def arm() -> fd.FlexibleJointModel:
    """The two-link arm with friction that sticks."""
    dry = fd.effects.CoulombFriction("elbow", side="motor", level=0.05)
    return fd.load_model("scara_two_link").replace(effects=[dry])


def hour(seconds: float) -> tuple[Row, fd.Run]:
    """One run of an hour, swinging under a controller; its time by the progress it tells."""
    t = np.arange(0.0, seconds + 0.05, 0.05)
    swing = np.stack([0.5 * np.sin(0.7 * t), 0.4 * np.sin(1.1 * t)], axis=1)
    command = fd.PD(fd.Samples(t, swing, "cubic"), kp=5.0, kd=0.5, rate=500.0)
    told: list[tuple[float, float, float]] = []

    def tell(reached: float) -> None:
        told.append((reached, time.process_time(), resident()))

    run = fd.simulate(arm(), command, seconds, fd.solvers.DormandPrince(), rate=50.0, progress=tell)
    marks = np.array(told)
    ends = [marks[min(len(marks) - 2, int(np.searchsorted(marks[:, 0], share * seconds)))] for share in (0.1, 0.2, 0.9)]
    ends.append(marks[-1])
    cost = [(b[1] - a[1]) / (b[0] - a[0]) for a, b in ((ends[0], ends[1]), (ends[2], ends[3]))]
    # Samples of the run were reserved before it began, and are touched as it fills them; so are a controller's torques.
    kept = (run.q.nbytes * 7 + 24 * 500.0 * seconds) / 1e6
    memory = (float(ends[1][2]), float(ends[3][2]))
    return Row("one run", f"{seconds:,.0f} s", memory, (float(cost[0]), float(cost[1])), kept), run


def models(count: int) -> Row:
    """Models with numbers of their own, each compiled and dropped."""
    base = arm()

    def work(k: int) -> None:
        joints = {"shoulder": {"stiffness": 30.0 + 1e-3 * k}}
        model = base.replace(joints=joints, effects=[*base.effects, fd.effects.Payload(mass=0.1 + 1e-6 * k)])
        fd.simulate(model, None, 1e-3)

    return repeated("models made and dropped", "models", count, work)


def short_runs(count: int) -> Row:
    """Runs of 10 ms of one model, a hundred at a time."""
    model = arm()
    starts = [np.array([0.01 * k, 0.5]) for k in range(100)]

    def work(k: int) -> None:
        fd.simulate_many([model] * 100, None, 0.01, q0=starts, threads=2)

    return repeated("short runs", "times 100 runs", count // 100, work)


def pages(run: fd.Run, count: int = PARTS) -> list[Row]:
    """The player's file and the plot's page of a run, each made a number of times."""
    found = []
    with tempfile.TemporaryDirectory() as folder:
        place = Path(folder)
        found.append(repeated("player's page", "times", count, lambda k: _played(run, place / "play.html")))
        size = (place / "play.html").stat().st_size / 1e6
        print(f"player's page of {run.t[-1]:,.0f} s: {size:.1f} MB", file=sys.stderr)
        found.append(repeated("plot's page", "times", count, lambda k: _plotted(run, place / "plot.html")))
        size = (place / "plot.html").stat().st_size / 1e6
        print(f"plot's page of {run.t[-1]:,.0f} s: {size:.1f} MB", file=sys.stderr)
    return found


def _played(run: fd.Run, path: Path) -> None:
    fd.play(run, html=path).close()


def _plotted(run: fd.Run, path: Path) -> None:
    run.plot().save(path)


def rows(share: float) -> list[Row]:
    """All of them, or a share of the work."""
    first, run = hour(3600.0 * share)
    return [first, models(int(10_000 * share)), short_runs(int(100_000 * share)), *pages(run)]


def main() -> int:
    """Work, print, write."""
    parser = arguments(__doc__)
    parser.add_argument("--share", type=float, default=1.0, help="of the work")
    args = parser.parse_args()
    warnings.simplefilter("ignore")  # limits of the robot
    found = rows(args.share)
    content: dict[str, Any] = {"rows": [asdict(row) for row in found]}
    print(long_runs_table(content))
    bounds = [bound for row in found for bound in row.bounds]
    return conclude(bounds, args.output, "python benchmarks/long_runs.py", content)


if __name__ == "__main__":
    sys.exit(main())
