"""The link side of the equations of motion: M(q), h(q, v), payloads, and the rotors of rigid joints."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import fields, replace
from functools import cached_property, lru_cache

import numpy as np
from numpy.typing import ArrayLike

from flexdyn import _core
from flexdyn.arrays import Array, Flags
from flexdyn.effects import Effect, InertiaEffect
from flexdyn.errors import InputError
from flexdyn.model.flexible_joint_model import FlexibleJointModel
from flexdyn.robot import Robot
from flexdyn.robot.tree import Tree


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

    def same_as(self, other: LinkSide) -> bool:
        """Whether another link side has the same numbers."""
        if self._tree is not other._tree:
            mine, its = _arrays(self._tree), _arrays(other._tree)
            if not all(np.array_equal(mine[name], its[name]) for name in mine):
                return False
        return bool(np.array_equal(self._gravity, other._gravity))

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

    def inverse_derivatives(self, q: ArrayLike, v: ArrayLike, a: ArrayLike) -> tuple[Array, Array]:
        """Derivatives of M(q) a + h(q, v) by q and by v (..., n, n) [N m/rad, N m s/rad], the torque's joint first."""
        q_, v_, a_ = self._columns(q, v, a)
        by_q, by_v = (np.empty((*q_.shape, self.n)) for _ in range(2))
        self._links.inverse_derivatives(q_, v_, a_, by_q, by_v)
        return by_q, by_v

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
        """Kinetic and gravitational energy (...,) [J]; the kinetic one includes the rotors of rigid joints.

        Args:
            q: link positions (..., n) [rad or m].
            v: their velocities (..., n).
        """
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
            raise InputError(f"{self.n} columns are needed, one for each joint", key="q", value=columns[0].shape)
        return [np.ascontiguousarray(column) for column in columns]


def build_links(model: FlexibleJointModel) -> _core.LinkDynamics:
    """The compiled link side: M(q), h(q, v), with payloads, and J of rigid joints as armature."""
    return LinkSide(model)._links


def _tree_of(true: FlexibleJointModel) -> Tree:
    """The tree of a resolved model, with payloads, and J of rigid joints as armature."""
    payloads = tuple(effect for effect in true.all_effects if isinstance(effect, InertiaEffect))
    armature = tuple(0.0 if joint.elastic else joint.reflected_inertia for joint in true.joints.values())
    return _loaded_tree(true.robot, payloads, armature)


@lru_cache(maxsize=16)
def _links(tree: Tree, gravity: tuple[float, ...]) -> _core.LinkDynamics:
    return _core.link_dynamics(_arrays(tree), np.array(gravity))


def with_payloads(robot: Robot, effects: Iterable[Effect]) -> Tree:
    """The robot's tree with the payloads among these effects."""
    tree = robot.tree
    for effect in effects:
        if isinstance(effect, InertiaEffect):
            frame, mass = effect.point_mass
            tree = tree.with_point_mass(robot.frame(robot.tip if frame is None else frame), mass)
    return tree


@lru_cache(maxsize=16)
def _loaded_tree(robot: Robot, payloads: tuple[InertiaEffect, ...], rigid_inertia: tuple[float, ...]) -> Tree:
    """The tree with payloads and rotors; rotors of rigid joints add to the inertia of their links."""
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


def moves_inertia(links: _core.LinkDynamics, q: Array) -> Flags:
    """Whether every joint moves an inertia at positions q (rows, n), so that M(q) is regular (rows,).

    The least eigenvalue of M(q), scaled to a diagonal of ones, is then above rounding.
    """
    rows, n = q.shape
    M = np.empty((rows, n, n))
    links.mass_matrix(q, M)
    diagonal = np.diagonal(M, axis1=1, axis2=2)
    regular = np.asarray((diagonal > 0.0).all(axis=1))
    scale = 1.0 / np.sqrt(diagonal[regular])
    regular[regular] = np.linalg.eigvalsh(M[regular] * scale[:, :, None] * scale[:, None, :])[:, 0] > 1e-13
    return regular
