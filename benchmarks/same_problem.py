"""Before any race: do all contestants solve the same problem?"""

from __future__ import annotations

import numpy as np
from arms import Arm, Array
from mujoco_arm import MujocoArm
from pinocchio_arm import PinocchioArm

import flexdyn as fd

SAME_ACCELERATION = 1e-9  # relative to the greatest of the state
SAME_MOTION = 1e-6  # rad over a second, at a tenth of the step raced with
SAME_DRY_MOTION = 5e-2  # rad over a second: both soften Sgn(u), each in its own way


def same_accelerations(arm: Arm, states: int = 200) -> float:
    """Greatest relative difference of MuJoCo's accelerations and pin.aba's at random states.

    Raises:
        RuntimeError: the two are not the same arm.
    """
    rng = np.random.default_rng(1)
    mujoco, pinocchio = MujocoArm(arm, "RK4", arm.step), PinocchioArm(arm)
    worst = 0.0
    for _ in range(states):
        q, v, omega = rng.uniform(-3.0, 3.0, (3, arm.n))
        theta = q + rng.uniform(-0.1, 0.1, arm.n)
        expected = pinocchio.derivative(0.0, np.concatenate([q, theta, v, omega]))[2 * arm.n :]
        difference = mujoco.acceleration(q, theta, v, omega) - expected
        worst = max(worst, float(np.abs(difference).max() / np.abs(expected).max()))
    return _no_more(worst, SAME_ACCELERATION, "MuJoCo's accelerations differ from pin.aba's")


def same_motions(arm: Arm) -> dict[str, float]:
    """Greatest distance from SciPy over pin.aba within a second, at a tenth of the step raced with [rad].

    Raises:
        RuntimeError: a contestant moves another way.
    """
    grid, step, between = np.linspace(0.0, 1.0, 11), arm.step / 10, round(1.0 / arm.step)
    truth = PinocchioArm(arm).scipy_positions("DOP853", grid, 1e-12, 1e-13)
    found = {
        "MuJoCo": MujocoArm(arm, "RK4", step).positions(10, between),
        "flexdyn": flexdyn_positions(arm, fd.solvers.RungeKutta4(step=step), grid),
    }
    return {
        name: _no_more(float(np.abs(positions - truth).max()), SAME_MOTION, f"{name} moves another way")
        for name, positions in found.items()
    }


def same_dry_motion(arm: Arm, smoothing: float) -> float:
    """Distance of flexdyn's smoothed Coulomb friction from MuJoCo's frictionloss within a second [rad].

    Raises:
        RuntimeError: they are further apart than two softened versions of one law would be.
    """
    grid, step, between = np.linspace(0.0, 1.0, 11), arm.step / 10, round(1.0 / arm.step)
    softened = flexdyn_positions(arm, fd.solvers.RungeKutta4(step=step, smoothing=smoothing), grid)
    difference = MujocoArm(arm, "RK4", step).positions(10, between) - softened
    return _no_more(float(np.abs(difference).max()), SAME_DRY_MOTION, "dry friction differs")


def flexdyn_positions(arm: Arm, solver: fd.solvers.Solver, grid: Array) -> Array:
    """[q, theta] at the times of the grid (len(grid), 2 n) [rad]."""
    run = fd.simulate(arm.model, arm.tau, float(grid[-1]), solver, q0=arm.q0, theta0=arm.theta0, times=grid)
    return np.hstack([run.q, run.theta])


def _no_more(value: float, bound: float, problem: str) -> float:
    if not value <= bound:
        raise RuntimeError(f"{problem}: by {value:.3g}, and {bound:g} is allowed; nothing was timed")
    return float(f"{value:.2g}")
