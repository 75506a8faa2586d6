"""Make the compiled plant, which computes, from the model, which describes."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field, fields, replace
from functools import cached_property, lru_cache
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from flexdyn import _core
from flexdyn.arrays import Array
from flexdyn.effects import Effect, JointCoupling, JointEffect, Payload, TorqueConstantError
from flexdyn.effects.coupling import CouplingFriction
from flexdyn.errors import InputError
from flexdyn.model.flexible_joint_model import FlexibleJointModel
from flexdyn.model.joint import Joint
from flexdyn.robot import Robot
from flexdyn.robot.axes import joint_row
from flexdyn.robot.tree import Tree

# Effects without a law in the plant: they change M and h, numbers of the model, or the measurement.
OTHER_STAGES = ("inertia", "model", "sensor")

# Stages that a law in Python may have, and their sides.
PYTHON_STAGES = {"actuator": ("motor",), "spring": ("transmission",), "friction": ("link", "motor")}


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


def build_links(model: FlexibleJointModel) -> _core.LinkDynamics:
    """The compiled link side: M(q), h(q, v), with payloads, and J of rigid joints as armature."""
    model.check_known()
    true = model.resolved()
    return _links(_tree_of(true), true.gravity)


def _tree_of(true: FlexibleJointModel) -> Tree:
    """The tree of a resolved model, with payloads, and J of rigid joints as armature."""
    payloads = tuple(effect for effect in true.all_effects if isinstance(effect, Payload))
    armature = tuple(0.0 if joint.elastic else joint.reflected_inertia for joint in true.joints.values())
    return _loaded_tree(true.robot, payloads, armature)


@lru_cache(maxsize=16)
def _links(tree: Tree, gravity: tuple[float, ...]) -> _core.LinkDynamics:
    return _core.link_dynamics(_arrays(tree), np.array(gravity))


class LinkSide:
    """M(q), h(q, v), accelerations and energies of the link side, over one state or many.

    Args:
        model: whose payloads and rigid rotor inertias are included.

    Example:
        >>> link = fd.LinkSide(fd.load_model("ur5"))
        >>> link.mass_matrix(np.zeros(6)).shape
        (6, 6)
    """

    def __init__(self, model: FlexibleJointModel) -> None:
        model.check_known()
        true = model.resolved()
        self._tree, self._gravity = _tree_of(true), true.gravity
        self.n = model.n

    @cached_property
    def _links(self) -> _core.LinkDynamics:
        """The compiled link side, made when it is first needed: for some only the inertias are needed."""
        return _links(self._tree, self._gravity)

    def mass_matrix(self, q: ArrayLike) -> Array:
        """M(q) (..., n, n) [kg m^2] of q (..., n)."""
        (q_,) = self._columns(q)
        out = np.empty((*q_.shape, self.n))
        self._links.mass_matrix(q_, out)
        return out

    def bias(self, q: ArrayLike, v: ArrayLike) -> Array:
        """h(q, v) (..., n) [N m]: Coriolis, centrifugal and gravity torques."""
        return self._filled(self._links.bias, q, v)

    def inverse_dynamics(self, q: ArrayLike, v: ArrayLike, a: ArrayLike) -> Array:
        """M(q) a + h(q, v) (..., n) [N m]."""
        return self._filled(self._links.inverse_dynamics, q, v, a)

    def extra_torques(self, others: Sequence[LinkSide], q: ArrayLike, v: ArrayLike, a: ArrayLike) -> Array:
        """Torques that the same arm with other inertias needs in addition to those of this one (..., k, n) [N m].

        ``M' a + h' - (M a + h)`` is linear in masses, first moments, inertias about the joints and armature, so that
        one pass over the motion is enough for all.

        Args:
            others: link sides that differ only in inertias.
            q: positions (..., n) [rad or m].
            v: velocities (..., n) [rad/s or m/s].
            a: accelerations (..., n) [rad/s^2 or m/s^2].
        """
        q_, v_, a_ = self._columns(q, v, a)
        own = self._tree.inertial_parameters
        more = np.stack([other._tree.inertial_parameters - own for other in others])
        out = np.empty((*q_.shape[:-1], len(others), self.n))
        self._links.inertial_torques(q_, v_, a_, more, out)
        return out

    def acceleration(self, q: ArrayLike, v: ArrayLike, tau: ArrayLike) -> Array:
        """Accelerations M(q)^-1 (tau - h(q, v)) (..., n) [rad/s^2], with tau on the links."""
        return self._filled(self._links.acceleration, q, v, tau)

    def energy(self, q: ArrayLike, v: ArrayLike) -> tuple[Array, Array]:
        """Kinetic and gravitational energy (...,) [J]; the kinetic one includes the rotors of rigid joints."""
        q_, v_ = self._columns(q, v)
        kinetic, potential = np.empty(q_.shape[:-1]), np.empty(q_.shape[:-1])
        self._links.energy(q_, v_, kinetic, potential)
        return kinetic, potential

    def _filled(self, law: Callable[..., None], *given: ArrayLike) -> Array:
        columns = self._columns(*given)
        out = np.empty(columns[0].shape)
        law(*columns, out)
        return out

    def _columns(self, *arrays: ArrayLike) -> list[Array]:
        columns = np.broadcast_arrays(*(np.asarray(array, dtype=float) for array in arrays))
        if columns[0].shape[-1:] != (self.n,):
            raise InputError(f"{self.n} columns are needed, one a joint", key="q", value=columns[0].shape)
        return [np.ascontiguousarray(column) for column in columns]


def with_payloads(robot: Robot, effects: Iterable[Effect]) -> Tree:
    """The robot's tree with the payloads among these effects."""
    tree = robot.tree
    for effect in effects:
        if isinstance(effect, Payload):
            tree = tree.with_point_mass(robot.frame(robot.tip if effect.frame is None else effect.frame), effect.mass)
    return tree


@lru_cache(maxsize=16)
def _loaded_tree(robot: Robot, payloads: tuple[Payload, ...], rigid_inertia: tuple[float, ...]) -> Tree:
    tree = with_payloads(robot, payloads)
    for axis in robot.axes:
        tree = tree.with_rotor(robot.joint_index(axis), prismatic=robot.angle_unit(axis) == "m")
    if not any(rigid_inertia):
        return tree
    armature = tree.armature.copy()
    for joint in np.flatnonzero(rigid_inertia):
        armature[_own_row(tree, int(joint))] += rigid_inertia[joint]
    return replace(tree, armature=armature)


def _own_row(tree: Tree, joint: int) -> int:
    """The joint of the tree that is the independent joint, not one that mimics it; for an axis its rotor."""
    unit = np.zeros(tree.gain.shape[1])
    unit[joint] = 1.0
    same = (tree.gain == unit).all(axis=1) & (tree.offset == 0.0)
    return int(np.flatnonzero(same)[0])


def _arrays(tree: Tree) -> dict[str, Array]:
    names = [field.name for field in fields(tree)]
    return {name: np.ascontiguousarray(getattr(tree, name), dtype=float) for name in names}


def acting_effects(model: FlexibleJointModel) -> list[Effect]:
    """The effects of a resolved model that have a law in the plant, in the plant's order of laws.

    Actuator effects are in the order in which they act; neutral effects are left out.
    """
    acting = [effect for effect in model.all_effects if not effect.is_neutral and effect.stage not in OTHER_STAGES]
    acting = [
        part for effect in acting for part in (effect.parts() if isinstance(effect, JointCoupling) else (effect,))
    ]
    acting = _gains_added(acting)
    return sorted(acting, key=lambda effect: effect.order)


def _gains_added(effects: list[Effect]) -> list[Effect]:
    """One torque-constant error for each joint: gains add, while separate laws would multiply."""
    gains: dict[str, float] = {}
    for effect in effects:
        if isinstance(effect, TorqueConstantError):
            gains[effect.joint] = gains.get(effect.joint, 0.0) + effect.gain
    others = [effect for effect in effects if not isinstance(effect, TorqueConstantError)]
    return [*(TorqueConstantError(joint, gain=gain) for joint, gain in gains.items()), *others]


def core_law(model: FlexibleJointModel, effect: Effect) -> _core.Law:
    """The law of an effect for the core.

    Raises:
        InputError: an effect that a plant cannot have.
    """
    if not isinstance(effect, JointEffect):
        raise InputError("an effect in the plant acts on a joint", key=effect.name, remedy="derive it from JointEffect")
    side, row = str(effect.side), joint_row(model.robot, effect.joint)
    joint = model.index(effect.joint) if row is None else int(np.flatnonzero(row)[0])
    if effect.is_python:
        _check_stage(effect)
        return _core.python_law(effect.stage, joint, side, _caller(effect))
    other = model.index(effect.other) if isinstance(effect, JointCoupling | CouplingFriction) else -1
    values = (effect.coefficient,) if isinstance(effect, JointCoupling) else effect.values
    try:
        return _core_law(effect.name, joint, side, values, other, () if row is None else tuple(row.tolist()))
    except ValueError:
        remedy = "write its law in Python: override torque(self, x, u, *, t, tau)"
        raise InputError("the core has no law of this name", key=effect.name, remedy=remedy) from None


_core_law = lru_cache(maxsize=256)(_core.law)


def _check_stage(effect: JointEffect) -> None:
    """Refuse a law in Python at a stage where the core cannot call it."""
    if effect.stage not in PYTHON_STAGES:
        remedy = f"it is {', '.join(PYTHON_STAGES)}"
        raise InputError("no stage for a law in Python", key=f"{effect.name}.stage", value=effect.stage, remedy=remedy)
    allowed = PYTHON_STAGES[effect.stage]
    if effect.side not in allowed:
        problem = f"a law of stage {effect.stage} does not act on this side"
        raise InputError(problem, key=f"{effect.name}.side", value=effect.side, remedy=f"it is {' or '.join(allowed)}")


def _caller(effect: JointEffect) -> Any:
    def call(t: float, x: float, u: float, tau: float) -> float:
        return float(effect.torque(x, u, t=t, tau=tau))

    return call


def _check_inertia(model: FlexibleJointModel, links: _core.LinkDynamics) -> None:
    """Refuse a joint that moves no inertia: ABA would divide by zero."""
    q = first_positions(model)
    if not moves_inertia(links, q[None])[0]:
        M = np.empty((model.n, model.n))
        links.mass_matrix(q, M)
        name = model.joint_names[int(np.argmin(np.diag(M)))]
        remedy = "give its links mass and inertia, or a rigid joint a rotor_inertia"
        raise InputError("the joint moves no inertia: M(q) is singular", key=f"joints.{name}", remedy=remedy)


def moves_inertia(links: _core.LinkDynamics, q: Array) -> NDArray[np.bool_]:
    """Whether every joint moves an inertia at positions q (rows, n), so that M(q) is regular (rows,)."""
    least = np.empty(len(q))
    links.least_inertia(q, least)
    return np.asarray(least > 1e-13)


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
