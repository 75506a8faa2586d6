"""The choice of the solver, and notes about it."""

from __future__ import annotations

import math
from dataclasses import asdict
from functools import lru_cache

import numpy as np

from flexdyn import _core
from flexdyn.arrays import Array
from flexdyn.effects import Effect
from flexdyn.errors import InputError
from flexdyn.model.flexible_joint_model import FlexibleJointModel
from flexdyn.simulation.plant import state_matrix
from flexdyn.simulation.solvers import (
    DormandPrince,
    DormandPrinceThenRosenbrock,
    Rosenbrock,
    RungeKutta4,
    Solver,
    make_solver,
)

STIFF = 2e4  # 1/s: an explicit method then takes steps below 0.2 ms for stability alone
STEP_BUDGETS: dict[type[Solver], tuple[int, int]] = {
    DormandPrince: (200_000, 50_000),
    Rosenbrock: (50_000, 40_000),
    DormandPrinceThenRosenbrock: (50_000, 40_000),
}
"""Steps that a run may try, and additional ones for every simulated second: about ten seconds for seven joints."""


def choose_solver(
    model: FlexibleJointModel, solver: Solver | str, plant: _core.Plant, x0: Array
) -> tuple[Solver, tuple[str, ...]]:
    """Choose the solver, and write notes about it.

    ``auto`` takes `DormandPrince`, the reference, unless the fastest rate at the start is above `STIFF`: then it takes
    `Rosenbrock`, whose steps are not limited by that rate. A run that meets such a rate later changes its solver there.

    Args:
        model: the arm.
        solver: settings, a name or ``auto``.
        plant: of the model.
        x0: first state.

    Raises:
        InputError: no such solver, or one that cannot take the model's dry friction.
    """
    notes: list[str] = []
    if solver == "auto":
        rate = fastest_rate(plant, x0)
        solver = Rosenbrock() if rate > STIFF else DormandPrince()
        reason = "above" if rate > STIFF else "below"
        limit = f"{reason} {STIFF:g} 1/s"
        notes.append(f"solver auto: {type(solver).__name__}, the fastest rate at the start is {rate:.3g} 1/s, {limit}")
    elif isinstance(solver, str):
        solver = make_solver(solver)
    if not isinstance(solver, Solver):
        raise InputError("a solver is needed", key="solver", value=solver, remedy="use fd.solvers.DormandPrince()")
    width = getattr(solver, "smoothing", None)
    if width is None and not isinstance(solver, RungeKutta4):
        return solver, tuple(notes)
    dry = [effect for effect in model.all_effects if _is_dry(effect) and not effect.is_neutral]
    if dry and width is None:
        remedy = "use DormandPrince, or give RungeKutta4 a smoothing in rad/s"
        problem = f"RungeKutta4 takes smooth laws only, and the model has {dry[0].name}"
        raise InputError(problem, key="solver", remedy=remedy)
    if dry:
        notes.append(f"dry friction is smoothed over {width:g} rad/s: a loaded joint creeps instead of sticking")
    return solver, tuple(notes)


def _is_dry(effect: Effect) -> bool:
    return any(part.stage == "dry" for part in effect.parts())


def switch_notes(notes: tuple[str, ...], solver: Solver) -> tuple[str, ...]:
    """The notes of a run, with an additional one if its solver changed during the run."""
    if not isinstance(solver, DormandPrinceThenRosenbrock):
        return notes
    return (*notes, f"solver: Rosenbrock from t = {solver.until:.6g} s on, where a rate above {STIFF:g} 1/s was met")


def fastest_rate(plant: _core.Plant, x0: Array) -> float:
    """The largest absolute eigenvalue of the motion linearised at x0, without dry friction [1/s]."""
    A = state_matrix(plant, 0.0, x0, np.zeros(plant.n), math.inf)  # friction smoothed so wide has no slope
    return float(np.abs(np.linalg.eigvals(A)).max()) if np.isfinite(A).all() else 0.0


def budget(solver: Solver, duration: float) -> int:
    """Steps that a run may try; 0: no limit, because fixed steps always reach the end.

    Args:
        solver: of the run.
        duration: of the run [s].
    """
    given = getattr(solver, "max_steps", None)
    if given is not None:
        return max(1, int(min(given, 1e15)))
    fixed, per_second = STEP_BUDGETS.get(type(solver), (0, 0))
    return int(min(fixed + per_second * duration, 1e15))


@lru_cache(maxsize=64)
def core_settings(
    solver: Solver, most: int = 0, *, max_steps: int = 0, stiff_rate: float = math.inf
) -> _core.SolverSettings:
    """A solver's settings for the core.

    Args:
        solver: the solver.
        most: largest number of evaluations of the equations of motion; 0: no limit.
        max_steps: largest number of tried steps, see `budget`; 0: no limit.
        stiff_rate: rate at which `Rosenbrock` replaces `DormandPrince` [1/s].
    """
    name, until = type(solver).__name__, math.inf
    if isinstance(solver, DormandPrinceThenRosenbrock):
        until, solver, name = solver.until, DormandPrince(), DormandPrince.__name__
    settings = {key: float(value) for key, value in asdict(solver).items() if value is not None}
    settings.pop("max_steps", None)
    then = Rosenbrock()
    stiff = {"stiff_rate": stiff_rate, "until": until, "stiff_rtol": then.rtol, "stiff_atol": then.atol}
    return _core.solver_settings(name, **settings, **stiff, most=most, max_steps=max_steps)
