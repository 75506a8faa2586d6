"""The energy ledger of a run: where the energy is, what came in, what each effect took out."""

from __future__ import annotations

import warnings
from collections.abc import Mapping
from dataclasses import dataclass, fields
from types import MappingProxyType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from flexdyn import _core
from flexdyn.drive import lower_wrenches
from flexdyn.effects import Effect
from flexdyn.job import core_settings
from flexdyn.plant import LinkSide, acting_effects, build_plant
from flexdyn.run import SIGNALS, Run
from flexdyn.solvers import RungeKutta4, Solver, TimeStepping

Array = NDArray[np.float64]


class EnergyWarning(UserWarning):
    """A run's energy ledger does not close to its solver's tolerance."""


@dataclass(frozen=True)
class Energy:
    """Where the energy of a motion is and went, sample by sample [J], each (samples,) unless said.

    ``mechanical - initial = supplied + external - sum of dissipated + residual``.

    Attributes:
        kinetic: of the links and rotors.
        spring: held by springs of all kinds: transmissions, bristles, hysteresis, parallel springs, counterbalances.
        gravity: of the links, from the height of the base.
        supplied: by each motor since the start, tau_applied omega integrated (samples, n).
        external: by wrenches since the start.
        dissipated: since the start, by ``effect.joint.side``; ``damping.JOINT`` is the joint's own. An end stop's entry
            holds what its spring still stores.
        initial: mechanical energy at the start of the run, which the first sample need not be [J].
        tolerance: that the residual should stay below [J].
    """

    kinetic: Array
    spring: Array
    gravity: Array
    supplied: Array
    external: Array
    dissipated: Mapping[str, Array]
    initial: float
    tolerance: float

    def __post_init__(self) -> None:
        """Lock every array."""
        for array in (self.kinetic, self.spring, self.gravity, self.supplied, self.external, *self.dissipated.values()):
            array.setflags(write=False)
        object.__setattr__(self, "dissipated", MappingProxyType(dict(self.dissipated)))

    def __reduce__(self) -> tuple[Any, ...]:
        """Pickle by its fields, through the constructor: a read-only mapping does not, and locks are lost."""
        values = [getattr(self, field.name) for field in fields(self)]
        return (type(self), tuple(dict(value) if isinstance(value, Mapping) else value for value in values))

    @property
    def mechanical(self) -> Array:
        """Kinetic, spring and gravity energy together: constant where nothing drives or brakes."""
        return self.kinetic + self.spring + self.gravity

    @property
    def residual(self) -> Array:
        """What the ledger leaves unexplained: the integration's error."""
        came = self.supplied.sum(axis=1) + self.external
        went = np.sum(list(self.dissipated.values()), axis=0) if self.dissipated else 0.0
        return np.asarray(self.mechanical - self.initial - came + went)

    @property
    def closes(self) -> bool:
        """Whether the residual stays within the tolerance."""
        return bool(np.abs(self.residual).max() <= self.tolerance)


def ledger(run: Run) -> Energy:
    """The energy ledger of a run, by going through its motion once more with every power integrated on the way.

    Warns:
        EnergyWarning: it does not close.
    """
    plant = build_plant(run.model)
    rows = len(run.t)
    sums = np.zeros((rows, plant.ledger_size))
    out = [np.empty((rows, run.model.n)) for _ in SIGNALS] + [np.empty((rows, plant.internal_states))]
    samples = run.inputs.samples
    signal = None if samples is None else _core.signal(*samples.pieces(samples.values))
    wrenches = lower_wrenches(run.model, run.inputs.external, run.inputs.duration)
    inputs = run.inputs
    settings = core_settings(run.solver)
    command = _core.open_loop(signal)
    job = _core.job(plant, command, wrenches, inputs.x0, inputs.duration, settings, run.t, out, sums)
    _core.simulate(job, None)
    energy = _energy(run, plant, sums)
    if not energy.closes:
        worst = float(np.abs(energy.residual).max())
        text = f"the energy ledger of {run.model.name} leaves {worst:.3g} J of {energy.tolerance:.3g} J unexplained"
        warnings.warn(
            f"{text}: {type(run.solver).__name__} does not resolve the motion", EnergyWarning, stacklevel=4
        )  # beyond Run.energy and its cached_property
    return energy


def _energy(run: Run, plant: _core.Plant, sums: Array) -> Energy:
    model, n = run.model.resolved(), run.model.n
    elastic = model.elastic
    speeds = np.hstack([run.v, run.omega[:, elastic]])
    # The first row is the start, which need not be among the samples.
    states = np.vstack([run.inputs.x0, np.hstack([run.q, run.theta[:, elastic], speeds, run.z])])
    half = speeds.shape[1]
    _, gravity = LinkSide(model).energy(states[:, :n], states[:, half : half + n])
    kinetic, spring = _kinetic(plant, states, states[:, half : 2 * half]), np.empty(len(states))
    plant.stored_energy(states, spring)
    dissipated: dict[str, Array] = {}
    for j in np.flatnonzero(elastic & (model.damping > 0)):
        dissipated[f"damping.{model.joint_names[j]}"] = sums[:, n + 1 + j].copy()
    for k, effect in enumerate(acting_effects(model)):
        lost = sums[:, 2 * n + 1 + k]
        if _has_entry(effect):
            label = _label(effect)
            dissipated[label] = dissipated.get(label, 0.0) + lost
    parts = [kinetic, spring, gravity]
    tolerance = _tolerance(run, parts, sums)
    initial = float(sum(part[0] for part in parts))
    kinetic, spring, gravity = (part[1:].copy() for part in parts)
    return Energy(kinetic, spring, gravity, sums[:, :n].copy(), sums[:, n].copy(), dissipated, initial, tolerance)


def _kinetic(plant: _core.Plant, states: Array, speeds: Array, chunk: int = 1000) -> Array:
    """1/2 w' H(q) w over the velocities w of links and rotors; in chunks, which bounds the memory of H."""
    width = speeds.shape[1]
    kinetic = np.empty(len(states))
    for first in range(0, len(states), chunk):
        rows = slice(first, first + chunk)
        H = np.empty((len(states[rows]), width, width))
        plant.inertia(np.ascontiguousarray(states[rows]), H)
        kinetic[rows] = 0.5 * np.einsum("ri,rij,rj->r", speeds[rows], H, speeds[rows])
    return kinetic


def _has_entry(effect: Effect) -> bool:
    """Whether an effect can take energy out; what a hardening spring takes in, it holds."""
    if effect.name == "hardening_spring":
        return False
    return effect.stage in ("friction", "dry", "spring") or effect.name == "end_stop"


def _label(effect: Effect) -> str:
    return ".".join(str(getattr(effect, key)) for key in ("name", "joint", "side"))


def _tolerance(run: Run, parts: list[Array], sums: Array) -> float:
    """What integration, absolute tolerance and rounding may leave of the energy that was turned over [J]."""
    turnover = max(np.ptp(parts[0]), np.ptp(parts[1]), np.abs(sums).max(initial=0.0))
    steps = max(100, run.stats.get("steps", 0))
    rounding = np.finfo(float).eps * steps * max(np.abs(part).max() for part in parts)
    moved = getattr(run.solver, "atol", 0.0) * max(np.abs(run.tau_applied).max(), np.abs(run.tau_s).max())
    return float(_relative(run.solver, steps) * turnover + rounding + moved)


def _relative(solver: Solver, steps: int) -> float:
    """Relative to what is turned over: local errors of rtol add up over the steps; a fixed step has its order."""
    if isinstance(solver, TimeStepping):
        return 1e-2  # order 1: it damps a little more than the arm does
    if isinstance(solver, RungeKutta4):
        return 1e-6
    return float(getattr(solver, "rtol", 1e-6)) * steps
