"""Make the compiled plant, which computes, from the model, which describes."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import lru_cache
from typing import Any

import numpy as np

from flexdyn import _core
from flexdyn.arrays import Array
from flexdyn.effects import Effect
from flexdyn.errors import InputError
from flexdyn.model.flexible_joint_model import FlexibleJointModel
from flexdyn.model.joint import Joint
from flexdyn.simulation.laws import acting_effects, core_law
from flexdyn.simulation.link_side import build_links, moves_inertia


def build_plant(model: FlexibleJointModel) -> _core.Plant:
    """The compiled plant of a model; neutral effects are left out, so that they change nothing, bit for bit.

    Models with the same numbers share a plant, even if their first states differ.

    Raises:
        InputError: a rigid joint that moves no inertia at all, or a number that is unknown.
    """
    model.check_known()
    true = model.resolved()
    links = build_links(true)
    _check_inertia(true, links)
    effects = tuple(acting_effects(true))
    parts = _Parts(links, tuple(true.joints.values()), effects, true.rotor_coupling, true)
    # A law in Python may have a state of its own: every plant needs its own law.
    plant = _assembled(parts) if any(effect.is_python for effect in effects) else _shared(parts)
    if plant.coupled:
        _check_coupling(true, plant)
    return plant


@dataclass(frozen=True)
class _Parts:
    """All inputs of a plant; equal inputs give the same plant."""

    links: _core.LinkDynamics
    joints: tuple[Joint, ...]
    effects: tuple[Effect, ...]
    rotor_coupling: str
    model: FlexibleJointModel = field(compare=False)


def _assembled(parts: _Parts) -> _core.Plant:
    model = parts.model
    laws = [core_law(model, effect) for effect in parts.effects]
    J, spin = model.rotor_inertia, rotor_spin(model)
    return _core.plant(parts.links, model.stiffness, model.damping, J, spin, laws)


_shared = lru_cache(maxsize=64)(_assembled)


def rotor_spin(model: FlexibleJointModel) -> Array:
    """J/N of every joint (n,) [kg m^2]: times omega it is the angular momentum of a rotor about its own axis.

    Zero if the model's rotor coupling is ``reduced``, which leaves out the effect of this momentum on the links.
    """
    if model.rotor_coupling == "reduced":
        return np.zeros(model.n)
    return np.array([joint.gear_ratio * joint.rotor_inertia for joint in model.joints.values()])


def _check_inertia(model: FlexibleJointModel, links: _core.LinkDynamics) -> None:
    """Refuse a joint that moves no inertia: ABA would divide by zero."""
    q = first_positions(model)
    if not moves_inertia(links, q[None])[0]:
        M = np.empty((model.n, model.n))
        links.mass_matrix(q, M)
        name = model.joint_names[int(np.argmin(np.diag(M)))]
        remedy = "give its links mass and inertia, or a rigid joint a rotor_inertia"
        raise InputError("the joint moves no inertia: M(q) is singular", key=f"joints.{name}", remedy=remedy)


def _check_coupling(model: FlexibleJointModel, plant: _core.Plant) -> None:
    """Refuse links with less inertia than their rotors: the kinetic energy would not be positive."""
    x = np.zeros(plant.state_size)
    x[: model.n] = first_positions(model)
    coupled_inertia(plant, x, model.n + int(model.elastic.sum()))


def coupled_inertia(plant: _core.Plant, x: Array, size: int, where: str = "") -> Array:
    """H(q) (size, size) of the velocities of links and rotors at a state.

    Raises:
        InputError: rotors are coupled, and the links have less inertia than the rotors that they carry, so that H(q) is
            not positive definite.
    """
    H = np.empty((size, size))
    plant.inertia(x, H)
    if plant.coupled and np.linalg.eigvalsh(H)[0] <= 0.0:
        problem = f"the inertia of the links is smaller than that of the rotors they carry{where}"
        remedy = "the URDF's links must include the rotors they carry; or take reduced"
        raise InputError(problem, key="robot.rotor_coupling", remedy=remedy)
    return H


def state_matrix(plant: _core.Plant, t: float, x: Array, tau: Array, smoothing: float = 0.0) -> Array:
    """A = d(x')/dx (nx, nx): the links' part is analytic, from Pinocchio; with full rotor coupling by differences.

    Every law stays on its branch at this state: a sliding contact keeps sliding, a gap stays open or closed, an end
    stop or a torque limit acts or does not. A contact that dry friction holds has no acceleration, unless dry friction
    is smoothed over a velocity [rad/s].
    """
    A = np.empty((len(x), len(x)))
    plant.jacobian(t, np.ascontiguousarray(x), np.ascontiguousarray(tau), smoothing, A)
    return A


def check_model(model: Any) -> None:
    """Refuse what is no model.

    Raises:
        InputError: it is none.
    """
    if not isinstance(model, FlexibleJointModel):
        raise InputError("a FlexibleJointModel is needed", key="model", value=model, remedy="use fd.load_model(...)")


def first_positions(model: FlexibleJointModel) -> Array:
    """Link positions (n,) in the model's `initial`, 0 where it names none [rad or m]."""
    known = model.initial.get("q", {})
    return np.array([known.get(joint, 0.0) for joint in model.joint_names])
