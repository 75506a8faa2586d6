"""The energy ledger of a run: the motion is integrated once more, together with every power."""

from __future__ import annotations

import warnings
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from flexdyn import _core
from flexdyn.arrays import Array
from flexdyn.effects import Effect
from flexdyn.errors import SimulationError
from flexdyn.io.locked import Locked
from flexdyn.io.notebook import Public
from flexdyn.model.flexible_joint_model import FlexibleJointModel
from flexdyn.simulation.inputs_and_signals import SIGNALS
from flexdyn.simulation.laws import acting_effects
from flexdyn.simulation.link_side import LinkSide
from flexdyn.simulation.plant import build_plant
from flexdyn.simulation.solver_choice import core_settings
from flexdyn.simulation.solvers import RungeKutta4, Solver, TimeStepping
from flexdyn.simulation.wrenches import lower_wrenches

if TYPE_CHECKING:
    from flexdyn.simulation.run import Run


ROWS_AT_ONCE = 1000
"""States whose inertias are in memory at a time."""
_ENERGIES = {
    "kinetic": "kinetic energy of links and rotors",
    "spring": "energy held by springs",
    "gravity": "energy of the links in the field of gravity",
    "external": "energy supplied by external wrenches since the start",
    "supplied": "energy supplied by the motors since the start",
    "dissipated": "energy dissipated since the start",
}


class EnergyWarning(UserWarning):
    """The energy ledger of a run does not close to the tolerance of its solver.

    Example:
        >>> issubclass(fd.EnergyWarning, UserWarning)
        True
    """


@dataclass(frozen=True)
class StoredEnergy(Locked):
    """Energy that an arm holds [J], each (samples,).

    Attributes:
        kinetic: of the links and rotors.
        spring: held by springs of all kinds: transmissions, bristles, hysteresis, parallel springs, counterbalances.
        gravity: of the links, from the height of the base.
    """

    kinetic: Array
    spring: Array
    gravity: Array

    @property
    def mechanical(self) -> Array:
        """The sum of kinetic, spring and gravity energy: constant if nothing drives or brakes."""
        return self.kinetic + self.spring + self.gravity


@dataclass(frozen=True, repr=False)
class Energy(StoredEnergy, Public):
    """Where the energy of a motion is and went, sample by sample [J], each (samples,) unless said.

    ``mechanical + magnetic - initial = supplied + external - sum of dissipated + residual``.

    Attributes:
        kinetic: of the links and rotors.
        spring: held by springs of all kinds: transmissions, bristles, hysteresis, parallel springs, counterbalances.
        gravity: of the links, from the height of the base.
        supplied: by each motor since the start, tau_applied omega integrated (samples, n); of a motor with inductance
            also what its winding took in, L i i'.
        external: by wrenches since the start.
        dissipated: since the start, by ``effect.joint.side``; ``damping.JOINT`` is the joint's own. An end stop's entry
            holds what its spring still stores.
        initial: mechanical and magnetic energy at the start of the run, which the first sample need not be [J].
        tolerance: that the residual should stay below [J].
        magnetic: 1/2 L i^2 in the windings of motors with inductance.

    Example:
        >>> run = fd.simulate(fd.load_model("scara_two_link"), duration=0.5, v0=[1.0, -2.0])
        >>> run.energy.closes
        True
        >>> bool(run.energy.dissipated["viscous_friction.elbow.link"][-1] > 0.0)
        True
    """

    supplied: Array
    external: Array
    dissipated: Mapping[str, Array]
    initial: float
    tolerance: float
    magnetic: Array

    def __repr__(self) -> str:
        """Supplied and dissipated energy of the whole run [J], in one line."""
        spent = sum(float(each[-1]) for each in self.dissipated.values())
        given = float(self.supplied[-1].sum())
        return f"<Energy: supplied {given:.4g} J, dissipated {spent:.4g} J, {len(self.kinetic)} samples>"

    @property
    def residual(self) -> Array:
        """The error of the ledger, which is the error of the integration."""
        came = self.supplied.sum(axis=1) + self.external
        went = np.sum(list(self.dissipated.values()), axis=0) if self.dissipated else 0.0
        return np.asarray(self.mechanical + self.magnetic - self.initial - came + went)

    @property
    def closes(self) -> bool:
        """Whether the residual stays within the tolerance."""
        return bool(np.abs(self.residual).max() <= self.tolerance)

    def added_to(self, dataset: Any) -> Any:
        """The xarray dataset of the run with the energies [J].

        Kinetic, spring, gravity and external energy are over ``t``, supplied over ``(t, joint)`` and dissipated over
        ``(t, entry)``.
        """
        lost = np.column_stack([*self.dissipated.values()]) if self.dissipated else np.empty((len(self.kinetic), 0))
        parts: dict[str, Any] = {
            name: ("t", getattr(self, name)) for name in ("kinetic", "spring", "gravity", "external")
        }
        parts |= {"supplied": (("t", "joint"), self.supplied), "dissipated": (("t", "entry"), lost)}
        dataset = dataset.assign_coords(entry=np.array(list(self.dissipated), dtype=str)).assign(parts)
        for name, words in _ENERGIES.items():
            dataset[name].attrs |= {"units": "J", "long_name": words}
        return dataset


def ledger(run: Run) -> Energy:
    """Compute the energy ledger of a run: its motion is integrated once more, together with every power.

    Raises:
        SimulationError: the motion cannot be integrated again.

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
    job = _core.job(plant, command, wrenches, inputs.x0, inputs.duration, core_settings(run.solver), run.t, out, sums)
    report = _core.simulate(job, None)
    if report["reason"]:  # a law in Python that does not give the same torque again
        problem = f"the motion could not be integrated again for its energy: {report['reason']}"
        raise SimulationError(problem, t=report["t"], state=report["x"], solver=run.solver, reason=report["reason"])
    energy = _energy(run, plant, sums)
    if not energy.closes:
        worst = float(np.abs(energy.residual).max())
        text = f"the energy ledger of {run.model.name} misses {worst:.3g} J, more than {energy.tolerance:.3g} J"
        text += f": {type(run.solver).__name__} does not resolve the motion"
        warnings.warn(text, EnergyWarning, stacklevel=4)  # beyond Run.energy and its cached_property
    return energy


def _energy(run: Run, plant: _core.Plant, sums: Array) -> Energy:
    """The ledger from the core's sums over the run, a row for each sample: n motors, wrenches, n dampers, effects."""
    model, n = run.model.resolved(), run.model.n
    elastic = model.elastic
    speeds = np.hstack([run.v, run.omega[:, elastic]])
    # The first row is the start, which may not be among the samples.
    states = np.vstack([run.inputs.x0, np.hstack([run.q, run.theta[:, elastic], speeds, run.z])])
    stored = stored_energy(model, plant, states)
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
    parts = [stored.kinetic, stored.spring, stored.gravity, magnetic]
    tolerance = _tolerance(run, parts, sums)
    initial = float(sum(part[0] for part in parts))
    kinetic, spring, gravity, magnetic = (part[1:].copy() for part in parts)
    supplied, external = sums[:, :n].copy(), sums[:, n].copy()
    return Energy(kinetic, spring, gravity, supplied, external, dissipated, initial, tolerance, magnetic)


def stored_energy(model: FlexibleJointModel, plant: _core.Plant, states: Array) -> StoredEnergy:
    """The energy that an arm holds.

    Args:
        model: of the arm, resolved.
        plant: of the same.
        states: [q, theta, v, omega, z] (samples, nx).
    """
    n, half = model.n, model.n + int(model.elastic.sum())
    _, gravity = LinkSide(model).energy(states[:, :n], states[:, half : half + n])
    spring = np.empty(len(states))
    plant.stored_energy(states, spring)
    return StoredEnergy(_kinetic(plant, states, states[:, half : 2 * half]), spring, gravity)


def _kinetic(plant: _core.Plant, states: Array, speeds: Array) -> Array:
    """1/2 w' H(q) w with the velocities w of links and rotors, in chunks to bound the memory of H."""
    width = speeds.shape[1]
    kinetic = np.empty(len(states))
    for first in range(0, len(states), ROWS_AT_ONCE):
        rows = slice(first, first + ROWS_AT_ONCE)
        H = np.empty((len(states[rows]), width, width))
        plant.inertia(np.ascontiguousarray(states[rows]), H)
        kinetic[rows] = 0.5 * np.einsum("ri,rij,rj->r", speeds[rows], H, speeds[rows])
    return kinetic


def _has_entry(effect: Effect) -> bool:
    """Whether an effect can take energy; what a law in Python stores, only its entry tells."""
    takes = effect.is_python or not effect.conservative
    return takes and effect.stage in ("friction", "dry", "spring", "link")


def _label(effect: Effect) -> str:
    """The entry of an effect in the ledger: its name, joint and side."""
    return ".".join((effect.part_of or effect.name, *(str(getattr(effect, key)) for key in ("joint", "side"))))


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
