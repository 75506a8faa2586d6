"""Compute the energy ledger of a run: the motion is integrated once more, together with every power."""

from __future__ import annotations

import warnings
from typing import TYPE_CHECKING

import numpy as np

from flexdyn import _core
from flexdyn.arrays import Array
from flexdyn.effects import Effect
from flexdyn.effects.coupling import CouplingFriction
from flexdyn.errors import SimulationError
from flexdyn.simulation.command_input import lower_wrenches
from flexdyn.simulation.energy import Energy, EnergyWarning
from flexdyn.simulation.inputs_and_signals import SIGNALS
from flexdyn.simulation.plant import LinkSide, acting_effects, build_plant
from flexdyn.simulation.solver_choice import core_settings
from flexdyn.simulation.solvers import RungeKutta4, Solver, TimeStepping

if TYPE_CHECKING:
    from flexdyn.simulation.run import Run


def ledger(run: Run) -> Energy:
    """Compute the energy ledger of a run: its motion is integrated once more, together with every power.

    Warns:
        EnergyWarning: it does not close.
    """
    plant = build_plant(run.model)
    rows = len(run.t)
    sums = np.zeros((rows, plant.ledger_size))
    out = [np.empty((rows, run.model.n)) for _ in SIGNALS] + [np.empty((rows, plant.internal_states))]
    inputs, samples = run.inputs, run.inputs.samples
    command = _core.open_loop(None if samples is None else _core.signal(*samples.pieces(samples.values)))
    wrenches = lower_wrenches(run.model, inputs.external, inputs.duration)
    settings = core_settings(run.solver)
    job = _core.job(plant, command, wrenches, inputs.x0, inputs.duration, settings, run.t, out, sums)
    report = _core.simulate(job, None)
    if report["reason"]:  # a law in Python that does not give the same torque again
        problem = f"the motion could not be integrated again for its energy: {report['reason']}"
        raise SimulationError(problem, t=report["t"], state=report["x"], solver=run.solver, reason=report["reason"])
    energy = _energy(run, plant, sums)
    if not energy.closes:
        worst = float(np.abs(energy.residual).max())
        text = f"the energy ledger of {run.model.name} misses {worst:.3g} J, more than {energy.tolerance:.3g} J"
        warnings.warn(
            f"{text}: {type(run.solver).__name__} does not resolve the motion", EnergyWarning, stacklevel=4
        )  # beyond Run.energy and its cached_property
    return energy


def _energy(run: Run, plant: _core.Plant, sums: Array) -> Energy:
    model, n = run.model.resolved(), run.model.n
    elastic = model.elastic
    speeds = np.hstack([run.v, run.omega[:, elastic]])
    # The first row is the start, which may not be among the samples.
    states = np.vstack([run.inputs.x0, np.hstack([run.q, run.theta[:, elastic], speeds, run.z])])
    half = speeds.shape[1]
    _, gravity = LinkSide(model).energy(states[:, :n], states[:, half : half + n])
    kinetic, spring = _kinetic(plant, states, states[:, half : 2 * half]), np.empty(len(states))
    plant.stored_energy(states, spring)
    magnetic = np.empty(len(states))
    plant.magnetic_energy(states, magnetic)
    dissipated: dict[str, Array] = {}
    for j in np.flatnonzero(elastic & (model.damping > 0)):
        dissipated[f"damping.{model.joint_names[j]}"] = sums[:, n + 1 + j].copy()
    for k, effect in enumerate(acting_effects(model)):
        lost = sums[:, 2 * n + 1 + k]
        if _has_entry(effect):
            label = _label(effect)
            dissipated[label] = dissipated.get(label, 0.0) + lost
    parts = [kinetic, spring, gravity, magnetic]
    tolerance = _tolerance(run, parts, sums)
    initial = float(sum(part[0] for part in parts))
    kinetic, spring, gravity, magnetic = (part[1:].copy() for part in parts)
    supplied, external = sums[:, :n].copy(), sums[:, n].copy()
    return Energy(kinetic, spring, gravity, supplied, external, dissipated, initial, tolerance, magnetic)


def _kinetic(plant: _core.Plant, states: Array, speeds: Array, chunk: int = 1000) -> Array:
    """1/2 w' H(q) w with the velocities w of links and rotors, in chunks to bound the memory of H."""
    width = speeds.shape[1]
    kinetic = np.empty(len(states))
    for first in range(0, len(states), chunk):
        rows = slice(first, first + chunk)
        H = np.empty((len(states[rows]), width, width))
        plant.inertia(np.ascontiguousarray(states[rows]), H)
        kinetic[rows] = 0.5 * np.einsum("ri,rij,rj->r", speeds[rows], H, speeds[rows])
    return kinetic


def _has_entry(effect: Effect) -> bool:
    """Whether an effect can take energy; a hardening spring only stores it."""
    if effect.name == "hardening_spring":
        return False
    return effect.stage in ("friction", "dry", "spring") or effect.name == "end_stop"


def _label(effect: Effect) -> str:
    name = "joint_coupling" if isinstance(effect, CouplingFriction) else effect.name
    return ".".join((name, *(str(getattr(effect, key)) for key in ("joint", "side"))))


def _tolerance(run: Run, parts: list[Array], sums: Array) -> float:
    """The error that integration, absolute tolerance and rounding may cause, from the energy that was converted [J]."""
    turnover = max(np.ptp(parts[0]), np.ptp(parts[1]), np.abs(sums).max(initial=0.0))
    steps = max(100, run.stats.get("steps", 0))
    rounding = np.finfo(float).eps * steps * max(np.abs(part).max() for part in parts)
    moved = getattr(run.solver, "atol", 0.0) * max(np.abs(run.tau_applied).max(), np.abs(run.tau_s).max())
    return float(_relative(run.solver, steps) * turnover + rounding + moved)


def _relative(solver: Solver, steps: int) -> float:
    """Tolerance relative to the converted energy: local errors add up over the steps; a fixed step has its order."""
    if isinstance(solver, TimeStepping):
        return 1e-2  # order 1: it adds some numerical damping
    if isinstance(solver, RungeKutta4):
        return 1e-6
    return float(getattr(solver, "rtol", 1e-6)) * steps
