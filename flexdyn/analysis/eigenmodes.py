"""modes: eigenfrequencies, damping ratios and shapes of an arm at a pose, and the anti-resonances of its motors."""

from __future__ import annotations

from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from flexdyn.analysis.analysed_model import checked_model, without
from flexdyn.analysis.modes_result import Modes
from flexdyn.analysis.pose import Pose, pose
from flexdyn.analysis.statics import Statics
from flexdyn.arrays import Array
from flexdyn.checks import check_known
from flexdyn.errors import InputError
from flexdyn.model.flexible_joint_model import FlexibleJointModel
from flexdyn.simulation.plant import state_matrix

Rotors = Literal["free", "held"]
ZERO_FREQUENCY_SHARE = 1e-10
"""Squared frequencies below this share of the largest one are zero [1]."""


class Tangent:
    """Small motions about a pose at rest: inertia s'' + damping s' + stiffness s = 0, s = [q (n), theta (e)].

    Args:
        statics: of the model; a motor's torque is constant, so that only the spring holds a free rotor.
        q: pose (n,).
        theta: rotor positions (n,).
        tau: commanded torques (n,).

    Attributes:
        inertia: M(q) with J of rigid joints, and J of rotors (n + e, n + e); S(q) with full rotor coupling.
        stiffness: symmetric (n + e, n + e).
        damping: (n + e, n + e).
    """

    def __init__(self, statics: Statics, q: Array, theta: Array, tau: Array) -> None:
        model, n = statics.model, statics.model.n
        half = n + int(model.elastic.sum())
        # Torques at rest have the same slopes with and without rotor coupling; without it Pinocchio has them exactly.
        A = state_matrix(statics.reduced_plant, statics.t, statics.state(q, theta), tau)
        reduced = np.zeros((half, half))
        reduced[:n, :n] = statics.links.mass_matrix(q)
        reduced[range(n, half), range(n, half)] = model.rotor_inertia[model.elastic]
        self.inertia = statics.inertia(q)
        velocity, z = slice(half, 2 * half), slice(2 * half, None)
        # From rest the state of a bristle or hysteresis follows its coordinate, z' = s': it acts as an additional
        # spring.
        stiffness = -reduced @ (A[velocity, :half] + A[velocity, z] @ A[z, velocity])
        self.stiffness = 0.5 * (stiffness + stiffness.T)
        self.damping = -reduced @ A[velocity, velocity]
        if not all(np.isfinite(matrix).all() for matrix in (A, self.inertia, self.stiffness, self.damping)):
            problem = "numbers of the linear model about the pose are too large for a double"
            raise InputError(problem, key="model", remedy="check stiffness, damping, rotor_inertia and the pose")

    def squared_frequencies(self, kept: Any = slice(None)) -> tuple[Array, Array]:
        """Squared frequencies (m,) [rad^2/s^2], rising, 0 for rounding errors; shapes (m, m) in columns.

        Args:
            kept: coordinates that move; the others are held.
        """
        from scipy.linalg import eigh

        everything = np.arange(len(self.inertia))
        place = np.ix_(everything[kept], everything[kept])
        squared, shapes = eigh(self.stiffness[place], self.inertia[place])
        largest = np.abs(np.diag(self.stiffness) / np.diag(self.inertia)).max()
        squared[np.abs(squared) <= ZERO_FREQUENCY_SHARE * largest] = 0.0
        return squared, shapes

    def poles(self, kept: Any) -> NDArray[np.complex128]:
        """Eigenvalues (2 m,) [rad/s] of the damped motion of some coordinates, by absolute value."""
        everything = np.arange(len(self.inertia))[kept]
        place, m = np.ix_(everything, everything), len(everything)
        inverse = np.linalg.inv(self.inertia[place])
        upper = np.hstack([np.zeros((m, m)), np.eye(m)])
        lower = np.hstack([-inverse @ self.stiffness[place], -inverse @ self.damping[place]])
        values = np.linalg.eigvals(np.vstack([upper, lower])).astype(complex)
        return values[np.lexsort((values.imag, np.abs(values)))]


def modes(model: FlexibleJointModel, q: Pose = None, *, rotors: Rotors = "free") -> Modes:
    """Free small vibrations of an arm about a pose at rest: K s = w^2 M s with s = [q, theta].

    M is M(q) with payloads, and J of the rotors; a rigid joint's J is part of M(q); full rotor coupling adds S(q). K is
    the whole tangent stiffness at the pose with loaded springs: stiffness of the transmissions (at their deflection
    there), dh/dq of gravity, parallel springs, position torques, end stops in contact, torque ripple, bristles of
    presliding friction and hysteresis. Motors give the constant torque that holds the pose. So an upright arm on free
    rotors has unstable modes, and an arm without gravity has rigid-body modes. The damping has all terms that are
    linear in velocity at rest. Dry friction and torque limits are left out.

    Args:
        model: the arm.
        q: pose (n,) or by joint [rad or m]; None: the model's `initial`.
        rotors: ``free``: motors give constant torques; ``held``: stiff control or brakes hold every rotor, and so the
            rigid joints.

    Returns:
        The modes, by frequency.

    Raises:
        InputError: arguments that do not fit the model, springs that cannot carry the pose, or held rotors although
            every joint is rigid.

    Example:
        >>> model = fd.load_model("ur5")
        >>> found = fd.modes(model, {"elbow_joint": 1.0})
        >>> bool((np.diff(found.frequencies) >= 0.0).all())
        True
    """
    model = checked_model(model)
    check_rotors(model, rotors)
    return modes_at(resting_statics(model), pose(model, q), rotors)


def check_rotors(model: FlexibleJointModel, rotors: str) -> None:
    """Refuse an unknown choice, and held rotors if every joint is rigid.

    Raises:
        InputError: either.
    """
    check_known(rotors, ("free", "held"), "no such choice", key="rotors", value=rotors, remedy="it is free or held")
    if rotors == "held" and not model.elastic.any():
        remedy = "give a joint a finite stiffness, or use rotors='free'"
        raise InputError("every joint is rigid: nothing moves with the rotors held", key="rotors", remedy=remedy)


def resting_statics(model: FlexibleJointModel) -> Statics:
    """Statics of the model without dry friction and torque limits."""
    return Statics(without(model, lambda effect: effect.stage == "dry" or effect.cuts_torque))


def modes_at(statics: Statics, q: Array, rotors: Rotors) -> Modes:
    """`modes` for a prepared model and checked arguments.

    Args:
        statics: of the prepared model.
        q: pose of the links (n,) [rad or m].
        rotors: ``free`` or ``held``.
    """
    model, n = statics.model, statics.model.n
    theta = statics.loaded_springs(q)
    tangent = Tangent(statics, q, theta, statics.holding(q, theta))
    kept = np.flatnonzero(model.elastic) if rotors == "held" else np.arange(len(tangent.inertia))
    squared, vectors = tangent.squared_frequencies(kept)
    damping = np.einsum("ik,ij,jk->k", vectors, tangent.damping[np.ix_(kept, kept)], vectors)
    vibrates = squared > 0
    ratios = np.full(len(squared), np.nan)
    ratios[vibrates] = 0.5 * damping[vibrates] / np.sqrt(squared[vibrates])
    shapes = np.zeros((len(squared), len(tangent.inertia)))
    shapes[:, kept] = (vectors / _largest(vectors)).T
    return Modes(
        name=model.name,
        joint_names=model.joint_names,
        q=q,
        rotors=rotors,
        frequencies=_hertz(squared),
        damping_ratios=ratios,
        kinds=tuple("vibration" if w > 0 else "rigid-body" if w == 0 else "unstable" for w in squared),
        link_shapes=shapes[:, :n].copy(),
        rotor_shapes=shapes[:, model.rotor_places],
        poles=tangent.poles(kept),
        anti_resonances=anti_resonances(tangent, model),
    )


def anti_resonances(tangent: Tangent, model: FlexibleJointModel) -> Array:
    """Eigenfrequencies with one rotor held and the others free (n, n + e - 1) [Hz], a row for each motor.

    Args:
        tangent: the linear arm at the pose.
        model: of the arm.
    """
    rows = []
    for held in model.rotor_places:
        kept = [i for i in range(len(tangent.inertia)) if i != held]
        rows.append(_hertz(tangent.squared_frequencies(kept)[0]) if kept else np.empty(0))
    return np.array(rows)


def _hertz(squared: Array) -> Array:
    return np.sqrt(np.maximum(squared, 0.0)) / (2.0 * np.pi)


def _largest(vectors: Array) -> Array:
    """The entry with the largest absolute value in every column."""
    return np.asarray(vectors[np.argmax(np.abs(vectors), axis=0), np.arange(vectors.shape[1])])
