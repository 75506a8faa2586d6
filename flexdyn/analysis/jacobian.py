"""Derivatives of x' = f(t, x, tau) at a state, from the compiled plant."""

from __future__ import annotations

import math

import numpy as np

from flexdyn.analysis.analysed_model import dry_effects, without
from flexdyn.analysis.statics import Statics
from flexdyn.arrays import Array
from flexdyn.effects import Effect
from flexdyn.model.flexible_joint_model import FlexibleJointModel


def dry_velocities(model: FlexibleJointModel) -> dict[int, list[Effect]]:
    """Dry effects, by the index of their velocity in [v (n), omega (e)].

    On a rigid joint the motor's dry friction acts on v.
    """
    contacts: dict[int, list[Effect]] = {}
    for j, effect in dry_effects(model):
        contacts.setdefault(int(model.rotor_places[j]) if effect.side == "motor" else j, []).append(effect)
    return contacts


def resting(model: FlexibleJointModel, x: Array) -> dict[int, list[Effect]]:
    """The effects of `dry_velocities` whose velocity is 0 at x."""
    half = model.n + int(model.elastic.sum())
    return {place: effects for place, effects in dry_velocities(model).items() if x[half + place] == 0.0}


def without_resting_friction(model: FlexibleJointModel, x: Array) -> FlexibleJointModel:
    """The model without the dry friction of contacts that rest at x; sliding contacts keep theirs."""
    still = [id(effect) for effects in resting(model, x).values() for effect in effects]
    return without(model, lambda effect: id(effect) in still)


def actuator_gains(statics: Statics, x: Array, tau: Array) -> Array:
    """d(tau_applied)/d(tau) of every motor (n,) [1]: 0 where it saturates."""
    model = statics.model
    n, e = model.n, int(model.elastic.sum())
    half = n + e
    h = 2.0**-10 * max(1.0, float(np.abs(tau).max()))
    up, down = np.empty(len(x)), np.empty(len(x))
    statics.reduced_plant.derivative(statics.t, x, tau + h, np.inf, up)
    statics.reduced_plant.derivative(statics.t, x, tau - h, np.inf, down)
    slope = (up - down) / (2.0 * h)
    # Acceleration times inertia is torque; without coupling the motor of an elastic joint acts only on its rotor.
    gains = statics.links.mass_matrix(x[:n]) @ slope[half : half + n]
    gains[model.elastic] = model.rotor_inertia[model.elastic] * slope[half + n : half + n + e]
    return gains


def sliding_rate(statics: Statics, x: Array, tau: Array) -> Array:
    """The derivative x' (nx,) at x, sliding contacts on their branch; the model of `statics` has none at rest."""
    model = statics.model
    half = model.n + int(model.elastic.sum())
    speeds = [abs(x[half + place]) for place in dry_velocities(model)]
    rate = np.empty(len(x))
    width = min(speeds, default=math.inf) / 64.0  # tanh(64) is 1 to the last bit
    statics.plant.derivative(statics.t, x, tau, width, rate)
    return rate
