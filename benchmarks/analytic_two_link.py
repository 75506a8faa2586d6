"""How exact is every solver? Against the paper's closed-form two-link equations, and at what cost.

    python benchmarks/analytic_two_link.py [-o FILE.json] [--rounds N]

The truth is eq. 12-19 of the paper written out by hand (two_link_equations.py), integrated by SciPy's DOP853 at
rtol 1e-13, atol 1e-14 over 5 s under a torque that is one cubic polynomial. Exit code 1 if a bound does not hold.
"""

from __future__ import annotations

import sys
from typing import Any

import numpy as np
from measure import Bound, Contestant, arguments, conclude, race
from result_tables import accuracy_table
from two_link_equations import DURATION, MAX_STEP, Q0, THETA0, TORQUE_TIMES, TORQUE_VALUES, Array, Friction, truth

import flexdyn as fd

STEPS = (2e-2, 1e-2, 5e-3, 2.5e-3, 1e-3, 5e-4, 2.5e-4)
TOLERANCES = (1e-4, 1e-6, 1e-8, 1e-10, 1e-12)
SMOOTHING = 0.05  # rad/s
CASES = {
    "viscous": (Friction(viscous=0.01), ("viscous_friction",)),
    "smoothed Coulomb": (
        Friction(viscous=0.01, level=0.02, width=SMOOTHING),
        ("viscous_friction", "coulomb_friction"),
    ),
    "smoothed eq. 1": (
        Friction(viscous=0.01, level=0.02, excess=0.01, velocity=0.05, width=SMOOTHING),
        ("viscous_friction", "coulomb_friction", "stribeck_friction"),
    ),
}
TIMED = 60.0  # s of motion: long enough that starting up does not count
ABA = "one bare ABA call"


def solvers() -> dict[str, fd.solvers.Solver]:
    """Every solver at its settings, by the name it has in the table."""
    fixed = {f"RungeKutta4, step {h:g} s": fd.solvers.RungeKutta4(step=h, smoothing=SMOOTHING) for h in STEPS}
    adaptive = {
        f"DormandPrince, rtol {r:.0e}": fd.solvers.DormandPrince(rtol=r, atol=r / 100, smoothing=SMOOTHING)
        for r in TOLERANCES
    }
    return {**fixed, **adaptive}


def arm_with(kinds: tuple[str, ...]) -> fd.FlexibleJointModel:
    """The shipped arm with these of its effects only."""
    model = fd.load_model("scara_two_link")
    return model.replace(effects=[effect for effect in model.effects if effect.name in kinds])


def simulate(
    model: fd.FlexibleJointModel, solver: fd.solvers.Solver, duration: float = DURATION, times: Array | None = None
) -> fd.Run:
    """The motion that the truth describes, sampled at 1 kHz unless times are given."""
    command = fd.Samples(TORQUE_TIMES, TORQUE_VALUES, "cubic")
    return fd.simulate(model, command, duration, solver, q0=Q0, theta0=THETA0, times=times)


def errors(friction: Friction, kinds: tuple[str, ...]) -> dict[str, Any]:
    """Greatest position error of every solver [rad], evaluations, and the truth's own uncertainty."""
    model, grid = arm_with(kinds), np.arange(5001) / 1000.0
    exact = truth(friction, grid)
    rows: dict[str, Any] = {}
    for name, solver in solvers().items():
        run = simulate(model, solver)
        error = float(np.abs(np.hstack([run.q, run.theta]) - exact).max())
        rows[name] = {"error_rad": float(f"{error:.3g}"), "evaluations": run.stats["evaluations"]}
    again = truth(friction, grid, rtol=3e-13, atol=3e-14, max_step=MAX_STEP / 2)
    return {"truth_uncertainty_rad": float(f"{np.abs(again - exact).max():.1g}"), "solvers": rows}


def order(rows: dict[str, Any]) -> float:
    """Slope of log error over log step of RungeKutta4 over the three finest steps; order 4 for a smooth law."""
    points = np.log([(h, rows[f"RungeKutta4, step {h:g} s"]["error_rad"]) for h in STEPS[-3:]])
    return float(np.polyfit(points[:, 0], points[:, 1], 1)[0])


def costs(rounds: int) -> dict[str, float]:
    """Time of one evaluation of the equations, all a solver does included, in bare ABA calls; viscous friction."""
    model = arm_with(CASES["viscous"][1])
    contestants = [_timed(name, model, solver) for name, solver in solvers().items()]
    contestants.append(_aba_calls(model))
    times = race(contestants, rounds)
    return {name: float(f"{np.median(column / times[ABA]):.3g}") for name, column in times.items() if name != ABA}


def _timed(name: str, model: fd.FlexibleJointModel, solver: fd.solvers.Solver) -> Contestant:
    def run(duration: float) -> fd.Run:
        return simulate(model, solver, duration, np.array([duration]))

    evaluations = run(TIMED).stats["evaluations"]
    return Contestant(name, lambda: run(TIMED), evaluations, setup=lambda: run(1e-6))


def _aba_calls(model: fd.FlexibleJointModel) -> Contestant:
    run = simulate(model, fd.solvers.DormandPrince(), TIMED, np.linspace(0.0, TIMED, 20_000))
    q, v, tau = run.q.copy(), run.v.copy(), run.tau_s.copy()
    out, links = np.empty_like(q), fd.LinkSide(model)._links
    return Contestant(ABA, lambda: links.acceleration(q, v, tau, out), len(q))


def bounds(cases: dict[str, Any]) -> list[Bound]:
    """What the solvers promise."""
    smooth = cases["viscous"]
    found = [Bound("RungeKutta4, viscous: |order - 4|", abs(smooth["order"] - 4.0), 0.1)]
    for name, case in cases.items():
        rows = case["solvers"]
        ours = max(rows[f"DormandPrince, rtol {r:.0e}"]["error_rad"] / r for r in TOLERANCES)
        found.append(Bound(f"DormandPrince, {name}: greatest error / rtol", ours, 100.0))
        found.append(Bound(f"RungeKutta4 at 2.5e-4 s, {name}: error [rad]", _last(rows, "RungeKutta4"), 1e-8))
        found.append(Bound(f"DormandPrince at 1e-12, {name}: error [rad]", _last(rows, "DormandPrince"), 1e-8))
    return found


def _last(rows: dict[str, Any], solver: str) -> float:
    return float([row["error_rad"] for name, row in rows.items() if name.startswith(solver)][-1])


def main() -> int:
    """Measure, print, write; 1 if a bound does not hold."""
    parser = arguments(__doc__)
    parser.add_argument("--rounds", type=int, default=31, help="how often every solver is timed")
    options = parser.parse_args()
    cases = {name: errors(friction, kinds) for name, (friction, kinds) in CASES.items()}
    for case in cases.values():
        case["order"] = float(f"{order(case['solvers']):.3g}")
    results = {"smoothing": SMOOTHING, "cases": cases, "cost_in_aba_calls": costs(options.rounds)}
    print(accuracy_table(results), end="\n\n")
    for name, case in cases.items():
        print(f"{name}: RungeKutta4 order {case['order']:.2f}; truth known to {case['truth_uncertainty_rad']:.0e} rad")
    held = bounds(cases)
    return conclude(
        held, options.output, "python benchmarks/analytic_two_link.py", results | {"rounds": options.rounds}
    )


if __name__ == "__main__":
    sys.exit(main())
