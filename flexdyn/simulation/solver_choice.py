"""Which solver runs, and what is worth saying about the choice."""

from __future__ import annotations

from dataclasses import asdict
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from flexdyn import _core
from flexdyn.errors import InputError
from flexdyn.model.flexible_joint_model import FlexibleJointModel
from flexdyn.simulation.solvers import DormandPrince, Rosenbrock, RungeKutta4, Solver, make_solver

STIFF = 2e4  # 1/s: an explicit method then takes steps below 0.2 ms for stability alone


def choose_solver(
    model: FlexibleJointModel, solver: Solver | str, plant: _core.Plant, x0: NDArray[np.float64]
) -> tuple[Solver, tuple[str, ...]]:
    """The solver that will run, and notes on it.

    ``auto`` takes `DormandPrince`, the reference, unless something decays or vibrates faster than `STIFF` where the
    run starts: then `Rosenbrock`, whose steps need not follow it.

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
    dry = [effect for effect in model.all_effects if effect.stage == "dry" and not effect.is_neutral]
    if dry and width is None:
        remedy = "use DormandPrince, or give RungeKutta4 a smoothing in rad/s"
        problem = f"RungeKutta4 takes smooth laws only, and the model has {dry[0].name}"
        raise InputError(problem, key="solver", remedy=remedy)
    if dry:
        notes.append(f"dry friction is smoothed over {width:g} rad/s: a loaded joint creeps instead of sticking")
    return solver, tuple(notes)


def fastest_rate(plant: _core.Plant, x0: NDArray[np.float64]) -> float:
    """The largest eigenvalue, by size, of the motion linearised at x0 [1/s]; dry friction takes no part."""
    size = plant.state_size
    jacobian = np.empty((size, size))
    plant.jacobian(0.0, x0, np.zeros(plant.n), 1e3, jacobian)  # so wide that the smoothed friction has no slope
    if not np.isfinite(jacobian).all():
        return 0.0
    return float(np.abs(np.linalg.eigvals(jacobian)).max())


@lru_cache(maxsize=64)
def core_settings(solver: Solver, most: int = 0) -> _core.SolverSettings:
    """A solver's settings for the core.

    Args:
        solver: whose.
        most: evaluations of the equations of motion after which a run has failed; 0: as many as it takes.
    """
    settings = {key: float(value) for key, value in asdict(solver).items() if value is not None}
    return _core.solver_settings(type(solver).__name__, **settings, most=most)
