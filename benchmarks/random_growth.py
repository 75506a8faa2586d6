"""Where DormandPrince and Rosenbrock part over several seconds: is one of them wrong, or is the arm chaotic?

    python benchmarks/random_growth.py [--count 60] [--seconds 3] [-o FILE.json]

Of the random models whose runs by the two solvers differ by more than 1e-3 at their default tolerances, each is run
again at tight ones, and once more with its first joint turned by 1e-9 rad. An error of integration grows
as such a turn does. If the solvers differ by no more than the turn makes of one solver, at any time before it
has grown to `LOST`, then neither is wrong: the arm multiplies whatever differs. Exit code 1 otherwise.
"""

from __future__ import annotations

import sys
import warnings
from typing import Any

import numpy as np
from measure import Bound, arguments, conclude
from random_models import Array, Problem, drawn
from random_runs import apart
from trust_tables import growth_table

import flexdyn as fd

TIGHT = (
    fd.solvers.DormandPrince(rtol=1e-12, atol=1e-14, max_steps=1e7),
    fd.solvers.Rosenbrock(rtol=1e-10, atol=1e-12, max_steps=1e7),
)
TURN = 1e-9  # rad or m: what errors of 1e-10 a step add up to
LOST = 1e-2  # of the motion: beyond it differences no longer grow in proportion
PARTED = 1e-3  # of the motion


def moved(problem: Problem, solver: fd.solvers.Solver, turn: float = 0.0) -> tuple[Array, Array]:
    """Times (samples,) and positions of links and rotors (samples, 2 n), the first joint turned at the start."""
    q0 = np.array(problem.start["q0"], dtype=float)
    q0[0] += turn
    run = Problem(problem.model, problem.command, problem.start | {"q0": q0}, problem.duration).run(solver, rate=500.0)
    return run.t, np.hstack([run.q, run.theta])


def growth(seed: int, seconds: float) -> dict[str, Any]:
    """How a small turn grows in a model, and the solvers' difference beside it."""
    problem = drawn(seed, duration=seconds)
    t, truth = moved(problem, TIGHT[0])
    size = np.abs(truth - truth[0]).max()

    def so_far(other: Array) -> Array:
        return np.maximum.accumulate(np.abs(other - truth).max(axis=1) / size)

    turned = so_far(moved(problem, TIGHT[0], TURN)[1])
    solvers = so_far(moved(problem, TIGHT[1])[1])
    before = turned < LOST
    end = int(np.count_nonzero(before)) - 1  # what was seen so far never falls
    return {
        "seed": seed,
        "joints": problem.model.n,
        "default": apart(
            *(problem.run(kind(), rate=100.0).q for kind in (fd.solvers.DormandPrince, fd.solvers.Rosenbrock))
        ),
        "factor": float(turned[end] * size / TURN),
        "lost": float(t[end]),
        "turned": float(turned[end]),
        "solvers": float(solvers[end]),
        "ratio": float((solvers[before] / np.maximum(turned[before], TURN / size)).max()),
    }


def parting(count: int, seconds: float) -> list[int]:
    """The seeds whose runs part at default tolerances."""
    found = []
    for seed in range(count):
        problem = drawn(seed, duration=seconds)
        try:
            one, other = (
                problem.run(kind(), rate=100.0).q for kind in (fd.solvers.DormandPrince, fd.solvers.Rosenbrock)
            )
        except fd.SimulationError:
            continue
        if apart(one, other) > PARTED:
            found.append(seed)
    return found


def main() -> int:
    """Look for such arms, print, write."""
    parser = arguments(__doc__)
    parser.add_argument("--count", type=int, default=60, help="models to look at")
    parser.add_argument("--seconds", type=float, default=3.0, help="of each run")
    args = parser.parse_args()
    warnings.simplefilter("ignore")  # limits of robots, which these have none of
    models = [growth(seed, args.seconds) for seed in parting(args.count, args.seconds)]
    content = {"count": args.count, "seconds": args.seconds, "models": models}
    print(growth_table(content))
    apart = max((each["ratio"] for each in models), default=0.0)
    bound = Bound("solvers apart / a turn of 1e-9 at the start", apart, 1.0)
    command = f"python benchmarks/random_growth.py --count {args.count} --seconds {args.seconds:g}"
    return conclude([bound], args.output, command, content)


if __name__ == "__main__":
    sys.exit(main())
