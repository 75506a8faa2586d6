"""Does an arm that friction holds stay where it is? flexdyn beside MuJoCo, a minute under constant load.

    python benchmarks/creep.py [-o FILE.json] [--figure FILE.png]

Both start at equilibrium, every joint loaded to a share of its dry level. MuJoCo's friction gives way slowly; where
gravity helps, the arm falls in the end. Exit code 1 if flexdyn's side that sticks moved.
"""

from __future__ import annotations

import sys
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from arms import Arm, Array, six_joints, two_link
from measure import Bound, arguments, conclude
from mujoco_arm import SETTINGS, MujocoArm
from mujoco_friction import IMPEDANCE, harden
from result_tables import markdown_table

import flexdyn as fd

DURATION = 60.0  # s
LOADS = (0.1, 0.5, 0.9, 0.99)
SHOWN = 0.5
STEP = 1e-3  # s
OURS: dict[str, fd.solvers.Solver] = {
    "flexdyn DormandPrince": fd.solvers.DormandPrince(),
    "flexdyn TimeStepping, 1 ms": fd.solvers.TimeStepping(step=STEP),
    "flexdyn TimeStepping, 10 ms": fd.solvers.TimeStepping(step=1e-2),
}
INTEGRATORS = ("Euler", "implicitfast", "RK4")
HARD = ", hard friction"


def link_held(load: float) -> Arm:
    """The two-link arm, dry friction on its links, its springs wound up to a share of the level."""
    arm = two_link(dry=True)
    tau = load * arm.coefficients("coulomb_friction", "link")
    return replace(arm, tau=tau, theta0=arm.q0 + tau / arm.model.stiffness, step=STEP)


def motor_held(load: float) -> Arm:
    """The UR5 against gravity, dry friction on its motors, driven to a share of the level beyond the weight."""
    arm = six_joints(dry=True)
    weight = fd.LinkSide(arm.model).bias(arm.q0, np.zeros(arm.n))
    tau = weight + load * arm.coefficients("coulomb_friction", "motor")
    return replace(arm, tau=tau, theta0=arm.q0 + weight / arm.model.stiffness, step=STEP)


CASES = {
    "two-link arm held by its links' friction": (link_held, 0),
    "UR5 held by its motors' friction": (motor_held, 1),
}


def drift(arm: Arm, side: int, contestant: str) -> Array:
    """Greatest way of any joint from where it started, on the side that sticks, every second [rad]."""
    if contestant in OURS:
        run = fd.simulate(arm.model, arm.tau, DURATION, OURS[contestant], q0=arm.q0, theta0=arm.theta0, rate=1.0)
        moved = run.theta if side else run.q
    else:
        peer = MujocoArm(arm, contestant.removeprefix("MuJoCo ").removesuffix(HARD), STEP)
        if contestant.endswith(HARD):
            harden(peer, STEP)
        rows = peer.positions(round(DURATION), round(1.0 / STEP))
        moved = rows[:, arm.n :] if side else rows[:, : arm.n]
    return np.asarray(np.abs(moved - moved[0]).max(axis=1))


def contestants() -> list[str]:
    """Flexdyn's solvers, and MuJoCo's integrators with friction as it comes and as hard as it can be made."""
    return [*OURS, *(f"MuJoCo {name}{friction}" for name in INTEGRATORS for friction in ("", HARD))]


def measure() -> dict[str, Any]:
    """Drifts at every load, and how the one shown grows."""
    found: dict[str, Any] = {}
    for title, (make, side) in CASES.items():
        curves = {load: {name: drift(make(load), side, name) for name in contestants()} for load in LOADS}
        found[title] = {
            "drift_rad": {
                str(load): {name: float(f"{curve[-1]:.3g}") for name, curve in rows.items()}
                for load, rows in curves.items()
            },
            "every_second_rad": {name: [float(f"{x:.3g}") for x in curve] for name, curve in curves[SHOWN].items()},
        }
    return found


def table(results: dict[str, Any]) -> str:
    """Drift after a minute."""
    header = [
        "drift after 60 s [rad]",
        *(f"{title.split()[0]}, load {load:g} L" for title in results for load in LOADS),
    ]
    rows = []
    for name in contestants():
        cells = [case["drift_rad"][str(load)][name] for case in results.values() for load in LOADS]
        rows.append([name, *("0.0" if value == 0.0 else f"{value:.1e}" for value in cells)])
    return markdown_table(header, rows)


def draw(results: dict[str, Any], path: Path) -> None:
    """Drift over time, one panel a case."""
    import matplotlib as mpl

    mpl.use("Agg")
    import matplotlib.pyplot as plt

    figure, panels = plt.subplots(1, len(results), figsize=(11.0, 4.6), sharey=True, layout="constrained")
    colours = {"Euler": "#e07b00", "implicitfast": "#f2b134", "RK4": "#b03a00"}
    for axes, (title, case) in zip(panels, results.items(), strict=True):
        curves = {name: np.array(curve) for name, curve in case["every_second_rad"].items()}
        seconds = np.arange(round(DURATION) + 1)
        for name, curve in curves.items():
            if name not in OURS:
                colour = colours[name.split()[1].rstrip(",")]
                axes.plot(seconds, curve, "--" if name.endswith(HARD) else "-", color=colour, label=name)
            else:
                axes.plot(seconds, curve, color="#0b3d91", linewidth=2.5, clip_on=False)
        ours = max(float(curve[-1]) for name, curve in curves.items() if name in OURS)
        axes.annotate(
            f"flexdyn, all solvers: {ours:.1f} rad",
            (30.0, 0.0),
            (30.0, 14.0),
            textcoords="offset points",
            color="#0b3d91",
            ha="center",
        )
        axes.set(title=f"{title},\nload {SHOWN:g} of the dry level", xlabel="t [s]", xlim=(0.0, DURATION))
        axes.set_yscale("symlog", linthresh=1e-8)
        axes.set_ylim(0.0, 10.0)
        axes.grid(visible=True, alpha=0.3)
    panels[0].set_ylabel("distance from the start [rad]")
    panels[0].legend(fontsize=8, loc="upper left", ncols=2)
    path.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(path, dpi=110)
    plt.close(figure)


def bounds(results: dict[str, Any]) -> list[Bound]:
    """What sticks does not move: not at any load, not with any solver."""
    return [
        Bound(f"{title}, load {load} L, {name}: drift [rad]", case["drift_rad"][load][name], 0.0)
        for title, case in results.items()
        for load in case["drift_rad"]
        for name in OURS
    ]


def main() -> int:
    """Measure, print, draw, write; 1 if anything of ours moved."""
    parser = arguments(__doc__)
    parser.add_argument("--figure", type=Path, default=Path(__file__).parent / "figures" / "creep.png")
    options = parser.parse_args()
    results = measure()
    draw(results, options.figure)
    print(table(results), end="\n\n")
    held = bounds(results)
    content = {
        "mujoco_settings": SETTINGS,
        "mujoco_hard_friction": {"solref": [2.0 * STEP, 1.0], "solimp": IMPEDANCE},
        "step_seconds": STEP,
        "cases": results,
    }
    return conclude(held, options.output, "python benchmarks/creep.py", content)


if __name__ == "__main__":
    sys.exit(main())
