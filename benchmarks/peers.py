"""flexdyn against MuJoCo, SciPy over pin.aba, a Python loop over pin.aba and bare ABA calls, in one run.

    python benchmarks/peers.py [-o FILE.json] [--rounds N]

Everything is the same arm, checked before anything is timed; contestants take turns within every round. Exit code 1
if one of the bounds at the end does not hold.
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from typing import Any

import numpy as np
import same_problem
from arms import Arm, Array, six_joints, two_link
from footprint import import_seconds, run_megabytes
from measure import Bound, Contestant, arguments, conclude, race, ratio, summary
from mujoco_arm import SETTINGS, MujocoArm
from pinocchio_arm import PinocchioArm
from result_tables import peers_table

import flexdyn as fd

ARMS: dict[str, Callable[..., Arm]] = {"two_link": two_link, "six_joints": six_joints}
STEPS = 20_000
PYTHON_STEPS = 500
SMOOTHING = 1e-2  # rad/s
RTOL, ATOL = 1e-8, 1e-10
OURS = "flexdyn RungeKutta4"
ABA = "four bare ABA calls, C++"
MUJOCO = "MuJoCo RK4"
ADAPTIVE = "flexdyn DormandPrince"


def step_contestants(arm: Arm, dry: Arm) -> list[Contestant]:
    """One step of everybody; the dry ones carry Coulomb friction besides."""
    python = PinocchioArm(arm)
    return [
        _flexdyn_steps(OURS, arm, fd.solvers.RungeKutta4(step=arm.step)),
        Contestant(ABA, _aba_calls(arm), STEPS),
        _mujoco_steps(MUJOCO, MujocoArm(arm, "RK4", arm.step)),
        _mujoco_steps("MuJoCo RK4, default flags", MujocoArm(arm, "RK4", arm.step, tuned=False)),
        _mujoco_steps("MuJoCo Euler", MujocoArm(arm, "Euler", arm.step)),
        _mujoco_steps("MuJoCo implicitfast", MujocoArm(arm, "implicitfast", arm.step)),
        Contestant(
            "Python RK4 loop over pin.aba",
            lambda: python.runge_kutta(python.x0, arm.step, PYTHON_STEPS),
            PYTHON_STEPS,
        ),
        _flexdyn_steps(f"{OURS}, Coulomb smoothed", dry, fd.solvers.RungeKutta4(step=dry.step, smoothing=SMOOTHING)),
        _mujoco_steps("MuJoCo RK4, frictionloss", MujocoArm(dry, "RK4", dry.step)),
        _mujoco_steps("MuJoCo Euler, frictionloss", MujocoArm(dry, "Euler", dry.step)),
    ]


def _flexdyn_steps(name: str, arm: Arm, solver: fd.solvers.RungeKutta4) -> Contestant:
    def run(steps: int) -> None:
        end = steps * arm.step
        fd.simulate(arm.model, arm.tau, end, solver, q0=arm.q0, theta0=arm.theta0, times=[end])

    return Contestant(name, lambda: run(STEPS + 1), STEPS, setup=lambda: run(1))


def _mujoco_steps(name: str, peer: MujocoArm) -> Contestant:
    def run() -> None:
        peer.reset()
        peer.steps(STEPS)

    return Contestant(name, run, STEPS)


def _aba_calls(arm: Arm) -> Callable[[], None]:
    """Four calls for each step of the arm's own motion; the loop over states is compiled."""
    run = fd.simulate(
        arm.model,
        arm.tau,
        STEPS * arm.step,
        fd.solvers.RungeKutta4(step=arm.step),
        q0=arm.q0,
        theta0=arm.theta0,
        rate=1.0 / arm.step,
    )
    q, v, tau = (np.ascontiguousarray(signal[:STEPS]) for signal in (run.q, run.v, run.tau_s))
    out, links = np.empty_like(q), fd.LinkSide(arm.model)._links

    def calls() -> None:
        for _ in range(4):
            links.acceleration(q, v, tau, out)

    return calls


def motion_methods(arm: Arm) -> dict[str, Callable[[], Array]]:
    """Five seconds of motion by everybody, as positions on a grid of 0.1 s."""
    grid, between = np.linspace(0.0, 5.0, 51), round(0.1 / arm.step)
    python = PinocchioArm(arm)
    euler, rk4 = MujocoArm(arm, "Euler", arm.step), MujocoArm(arm, "RK4", arm.step)
    fixed = fd.solvers.RungeKutta4(step=arm.step)
    adaptive = fd.solvers.DormandPrince(rtol=RTOL, atol=ATOL)
    return {
        ADAPTIVE: lambda: same_problem.flexdyn_positions(arm, adaptive, grid),
        OURS: lambda: same_problem.flexdyn_positions(arm, fixed, grid),
        MUJOCO: lambda: rk4.positions(50, between),
        "MuJoCo Euler": lambda: euler.positions(50, between),
        "SciPy DOP853 over pin.aba": lambda: python.scipy_positions("DOP853", grid, RTOL, ATOL),
        "SciPy LSODA over pin.aba": lambda: python.scipy_positions("LSODA", grid, RTOL, ATOL),
        "Python RK4 loop over pin.aba": lambda: python.runge_kutta_positions(50, between, arm.step),
    }


def measure_arm(make: Callable[..., Arm], rounds: int) -> dict[str, Any]:
    """Checks, steps and motions of one arm."""
    arm, dry = make(), make(dry=True)
    found: dict[str, Any] = {
        "joints": arm.n,
        "step_seconds": arm.step,
        "acceleration_difference": same_problem.same_accelerations(arm),
        "motion_difference_rad": same_problem.same_motions(arm),
        "dry_motion_difference_rad": same_problem.same_dry_motion(dry, SMOOTHING),
    }
    times = race(step_contestants(arm, dry), rounds)
    found["steps"] = {name: summary(times, name, OURS) for name in times}
    found["step_over_aba"] = ratio(times, OURS, ABA)
    found["step_over_mujoco"] = ratio(times, OURS, MUJOCO)
    methods = motion_methods(arm)
    truth = PinocchioArm(arm).scipy_positions("DOP853", np.linspace(0.0, 5.0, 51), 1e-12, 1e-13)
    times = race([Contestant(name, run) for name, run in methods.items()], max(3, rounds // 4))
    found["motions"] = {
        name: summary(times, name, ADAPTIVE) | {"error_rad": float(f"{np.abs(run() - truth).max():.2g}")}
        for name, run in methods.items()
    }
    return found


def bounds(arms: dict[str, Any], extra_import: float, megabytes: float) -> list[Bound]:
    """What flexdyn promises."""
    two = arms["two_link"]
    return [
        Bound("two joints, RK4 step / MuJoCo's RK4 step", two["step_over_mujoco"], 0.3),
        Bound("two joints, RK4 step / four bare ABA calls", two["step_over_aba"], 1.3),
        Bound("import flexdyn after numpy and pinocchio [s]", extra_import, 0.3),
        Bound("memory of 60 s of seven joints at 1 kHz [MB]", megabytes, 60.0),
    ]


def main() -> int:
    """Measure, print, write; 1 if a bound does not hold."""
    parser = arguments(__doc__)
    parser.add_argument("--rounds", type=int, default=31, help="how often every contestant runs")
    options = parser.parse_args()
    base, extra = import_seconds()
    megabytes = run_megabytes()
    arms = {name: measure_arm(make, options.rounds) for name, make in ARMS.items()}
    print(peers_table({"arms": arms}), end="\n\n")
    held = bounds(arms, extra, megabytes)
    content = {
        "mujoco_settings": SETTINGS,
        "tolerances": {"rtol": RTOL, "atol": ATOL},
        "smoothing": SMOOTHING,
        "rounds": options.rounds,
        "import_seconds": {"numpy and pinocchio": base, "flexdyn besides": extra},
        "arms": arms,
    }
    return conclude(held, options.output, "python benchmarks/peers.py", content)


if __name__ == "__main__":
    sys.exit(main())
