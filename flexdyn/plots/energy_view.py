"""Energies as panels: stored energy, supplied and dissipated energy, and the error of the ledger."""

from __future__ import annotations

import numpy as np

from flexdyn.arrays import Array
from flexdyn.model.flexible_joint_model import FlexibleJointModel
from flexdyn.plots.file_energy import FileEnergy, file_energy
from flexdyn.plots.palette import INK, LOSSES, PARTS
from flexdyn.plots.panel import Curve, Panel, limits
from flexdyn.plots.scene import PlotScene
from flexdyn.plots.thinning import outline
from flexdyn.plots.views import TIME
from flexdyn.simulation.energy import Energy

Entries = dict[str, tuple[Array, str]]
"""Curves of a panel: values and colour by label."""
UP = "energy [J]"
ALL = "all of it"


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
        found = file_energy(source.recording, model)
        flows = {"supplied by the motors": (found.supplied, PARTS["supplied"])}
        flows["lost to friction, wrenches, sampling"] = (found.rest, LOSSES[0])
        return (
            _panel(f"Energy{name}: where it is", scene, place, _stored(found)),
            _panel(f"Energy{name}: supplied and lost since the first sample", scene, place, flows),
        )
    energy = source.run.energy
    within = "closes" if energy.closes else "does NOT close"
    left = {"left over": (energy.residual, PARTS["residual"])}
    return (
        _panel(f"Energy{name}: where it is", scene, place, _stored(energy)),
        _panel(f"Energy{name}: supplied and dissipated since the start", scene, place, _flows(energy)),
        _panel(f"Energy{name}: error of the ledger, which {within} to {energy.tolerance:.2g} J", scene, place, left),
    )


def _stored(energy: Energy | FileEnergy) -> Entries:
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


def _panel(title: str, scene: PlotScene, place: int, entries: Entries) -> Panel:
    rows = scene.rows[place]
    t = scene.sources[place].recording.t[rows]
    curves = []
    for label, (values, colour) in entries.items():
        kept = outline(t, values[rows])
        curves.append(Curve(t[kept], values[rows][kept], label, label, colour, width=2.2 if label == ALL else 1.3))
    return Panel(
        title,
        TIME,
        UP,
        tuple(curves),
        x_range=scene.span,
        y_range=limits(*(curve.y for curve in curves)),
        colour=INK,
        timed=True,
        legend=True,
        level=True,
    )
