"""Energies of a saved run, as far as its samples and its model determine them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from flexdyn.arrays import Array
from flexdyn.effects import SensorEffect
from flexdyn.errors import InputError
from flexdyn.model.flexible_joint_model import FlexibleJointModel
from flexdyn.model.model_file import model_in
from flexdyn.records import Recording
from flexdyn.simulation.inputs_and_signals import SIGNALS
from flexdyn.simulation.plant import LinkSide, build_plant


@dataclass(frozen=True, eq=False)
class FileEnergy:
    """Energies of a saved run [J], each (samples,).

    Kinetic, spring and gravity energy follow exactly from the state of every sample. The energy supplied by the motors
    is a sum over the samples, with tau_applied held from each to the next. A file does not determine the rest.

    Attributes:
        kinetic: of links and rotors.
        spring: stored in springs.
        gravity: of the links.
        supplied: by the motors since the first sample.
    """

    kinetic: Array
    spring: Array
    gravity: Array
    supplied: Array

    @property
    def mechanical(self) -> Array:
        """Kinetic, spring and gravity energy together."""
        return self.kinetic + self.spring + self.gravity

    @property
    def rest(self) -> Array:
        """The supplied energy that is not stored: lost to friction, taken by wrenches, or an error of the sampling."""
        return np.asarray(self.supplied - (self.mechanical - self.mechanical[0]))


def file_energy(recording: Recording, model: FlexibleJointModel | None) -> FileEnergy:
    """Energies of a saved run.

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
    if model.rotor_coupling == "full":
        raise InputError("the energy of coupled rotors is not taken from files")
    q, theta, v, omega, _, applied, _ = (recording.signal(signal, model.joint_names) for signal in SIGNALS)
    elastic = model.elastic
    kinetic, gravity = LinkSide(model).energy(q, v)
    rotors = 0.5 * (omega[:, elastic] ** 2 @ true.rotor_inertia[elastic])
    spring = np.empty(len(q))
    plant.stored_energy(np.hstack([q, theta[:, elastic], v, omega[:, elastic]]), spring)
    work = np.sum(applied[:-1] * np.diff(theta, axis=0), axis=1)
    return FileEnergy(kinetic + rotors, spring, gravity, np.concatenate([[0.0], np.cumsum(work)]))


def _model_in(recording: Recording) -> FlexibleJointModel:
    found = model_in(recording)
    if found is None:
        raise InputError("the file does not hold its model; give it as model (--model)")
    return found
