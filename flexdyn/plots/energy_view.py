"""Energies as panels: stored, supplied, dissipated; of a saved run, as far as samples and model determine them."""

from __future__ import annotations

import numpy as np

from flexdyn.arrays import Array
from flexdyn.effects import SensorEffect
from flexdyn.errors import InputError
from flexdyn.model.flexible_joint_model import FlexibleJointModel
from flexdyn.model.model_file import model_in
from flexdyn.plots.palette import INK, LOSSES, PARTS
from flexdyn.plots.panel import Panel
from flexdyn.plots.scene import PlotScene
from flexdyn.plots.thinning import curve_over_time
from flexdyn.records import Recording
from flexdyn.simulation.energy import Energy, StoredEnergy, stored_energy
from flexdyn.simulation.inputs_and_signals import SIGNALS
from flexdyn.simulation.plant import build_plant

Entries = dict[str, tuple[Array, str]]
"""Curves of a panel: values and colour by label."""
UP = "energy [J]"
ALL = "all of it"


def file_energy(recording: Recording, model: FlexibleJointModel | None) -> tuple[StoredEnergy, Array]:
    """Energies of a saved run, and what its motors have supplied since the first sample (samples,) [J].

    Kinetic, spring and gravity energy follow exactly from the state of every sample. The energy supplied by the motors
    is a sum over the samples, with tau_applied held from each to the next. A file does not determine the rest.

    Args:
        recording: with the signals of a run.
        model: that was simulated; None: the model in the recording.

    Raises:
        InputError: there is no model, or the signals of the run do not determine its energies.
    """
    model = model if model is not None else _model_in(recording)
    true = model.resolved()
    for joint in model.joint_names:
        for signal in SIGNALS:
            if not recording.has(signal, joint):
                raise InputError(f"the file has no {signal}.{joint}")
    if any(isinstance(effect, SensorEffect) and not effect.is_neutral for effect in true.effects):
        raise InputError("the model's sensors report other signals than the true ones")
    plant = build_plant(model)
    if plant.internal_states:
        raise InputError("the file does not hold the states of its friction and springs with memory")
    q, theta, v, omega, _, applied, _ = (recording.signal(signal, model.joint_names) for signal in SIGNALS)
    elastic = model.elastic
    stored = stored_energy(true, plant, np.hstack([q, theta[:, elastic], v, omega[:, elastic]]))
    work = np.sum(applied[:-1] * np.diff(theta, axis=0), axis=1)
    return stored, np.concatenate([[0.0], np.cumsum(work)])


def _model_in(recording: Recording) -> FlexibleJointModel:
    found = model_in(recording)
    if found is None:
        raise InputError("the file does not hold its model; give it as model (--model)")
    return found


def energy_panels(scene: PlotScene, place: int, model: FlexibleJointModel | None) -> tuple[Panel, ...]:
    """The energies of one motion: the ledger of a run in three panels, the energies from a file in two.

    Args:
        scene: the motions that are drawn.
        place: index of the motion.
        model: of motions from files without a model.

    Raises:
        InputError: the file does not determine its energies.
    """
    source = scene.sources[place]
    name = f" of {source.name}" if len(scene.sources) > 1 else ""
    if source.run is None:
        found, supplied = file_energy(source.recording, model)
        rest = supplied - (found.mechanical - found.mechanical[0])
        flows = {"supplied by the motors": (supplied, PARTS["supplied"])}
        flows["lost to friction, wrenches, sampling"] = (rest, LOSSES[0])
        return (
            _energy_panel(f"Energy{name}: where it is", scene, place, _stored(found)),
            _energy_panel(f"Energy{name}: supplied and lost since the first sample", scene, place, flows),
        )
    energy = source.run.energy
    within = "closes" if energy.closes else "does NOT close"
    left = {"left over": (energy.residual, PARTS["residual"])}
    return (
        _energy_panel(f"Energy{name}: where it is", scene, place, _stored(energy)),
        _energy_panel(f"Energy{name}: supplied and dissipated since the start", scene, place, _flows(energy)),
        _energy_panel(
            f"Energy{name}: error of the ledger, which {within} to {energy.tolerance:.2g} J", scene, place, left
        ),
    )


def _stored(energy: StoredEnergy) -> Entries:
    """Kinetic energy, energy of springs and of gravity if there are any, and the sum."""
    parts = {part: getattr(energy, part) for part in ("kinetic", "spring", "gravity")}
    shown = {part: (values, PARTS[part]) for part, values in parts.items() if part == "kinetic" or np.any(values)}
    return {ALL: (energy.mechanical, PARTS["mechanical"]), **shown}


def _flows(energy: Energy) -> Entries:
    """The energy that motors and wrenches supplied, and the energy that effects took."""
    flows = {"supplied by the motors": (energy.supplied.sum(axis=1), PARTS["supplied"])}
    if np.any(energy.external):
        flows["supplied by wrenches"] = (energy.external, PARTS["external"])
    losses = _losses(energy)
    for i, loss in enumerate(sorted(losses)):
        flows[f"lost: {loss}"] = (losses[loss], LOSSES[i % len(LOSSES)])
    return flows


def _losses(energy: Energy) -> dict[str, Array]:
    """Dissipated by each kind of effect, over all joints and sides together."""
    found: dict[str, Array] = {}
    for label, lost in energy.dissipated.items():
        kind = label.partition(".")[0]
        found[kind] = found.get(kind, 0.0) + lost
    return found


def _energy_panel(title: str, scene: PlotScene, place: int, entries: Entries) -> Panel:
    """Energies of one motion over time."""
    rows = scene.rows[place]
    t = scene.sources[place].recording.t[rows]
    curves = tuple(
        curve_over_time(t, values[rows], label, label, colour, width=2.2 if label == ALL else 1.3)
        for label, (values, colour) in entries.items()
    )
    return Panel.over_time(title, UP, curves, scene.span, colour=INK, legend=True, level=True)
