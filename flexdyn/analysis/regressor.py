"""Equations of motion along samples as columns: torques are linear in the numbers of bodies, rotors and friction."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import pinocchio as pin

from flexdyn.arrays import Array
from flexdyn.effects import JointEffect
from flexdyn.errors import InputError
from flexdyn.model.flexible_joint_model import FlexibleJointModel
from flexdyn.records.given import as_recording
from flexdyn.records.signals.derivatives import derivatives
from flexdyn.robot.tree import Tree
from flexdyn.simulation.link_side import with_payloads

MOST_SAMPLES_ALONG = 4000
"""Largest number of samples of a recording that are used; of more, evenly spaced ones."""
BODY = ("m", "mx", "my", "mz", "Ixx", "Ixy", "Iyy", "Ixz", "Iyz", "Izz")
"""Numbers of a body in Pinocchio's order: mass [kg], mass times centre [kg m], inertia about its joint [kg m^2]."""
FRICTION = ("viscous", "coulomb", "offset")
"""Numbers of a joint's friction: [N m s/rad], [N m], [N m]."""


@dataclass(frozen=True, eq=False)
class Along:
    """Samples of a motion.

    Attributes:
        q, v, a: of the links (samples, n) [rad, rad/s, rad/s^2].
        omega, alpha: of the rotors (samples, n).
        every: number of samples of the recording for each of these.
    """

    q: Array
    v: Array
    a: Array
    omega: Array
    alpha: Array
    every: int = 1


def along_samples(model: FlexibleJointModel, q: Array, v: Array, a: Array) -> Along:
    """Take samples as they are given; rotors move with their links.

    Args:
        model: of the arm.
        q: positions (samples, n) [rad or m].
        v: velocities.
        a: accelerations.

    Raises:
        InputError: not all of one shape (samples, n), or numbers that are not finite.
    """
    for name, each in (("q", q), ("v", v), ("a", a)):
        if each.ndim != 2 or each.shape != (len(q), model.n) or not len(q):
            remedy = f"(samples, {model.n}), the same for q, v and a"
            raise InputError("wrong shape", key=name, value=each.shape, remedy=remedy)
        if not np.isfinite(each).all():
            raise InputError("numbers that are not finite", key=name)
    return Along(q, v, a, v, a)


def along_recording(model: FlexibleJointModel, recording: Any) -> Along:
    """Smooth and differentiate a recording; a missing encoder is replaced by the joint's other one.

    Raises:
        InputError: a joint without any position, or samples that cannot be differentiated.
    """
    recording = as_recording(recording, "motion", signals=True)
    channels = []
    for joint in model.joint_names:
        pair = [f"{signal}.{joint}" for signal in ("q", "theta") if recording.has(signal, joint)]
        if not pair:
            remedy = f"record q.{joint} or theta.{joint}"
            raise InputError("no position of the joint was recorded", key=joint, remedy=remedy)
        channels.append((pair[0], pair[-1]))
    seen = derivatives(recording, [name for name, _ in channels])
    every = max(1, -(-len(seen.t) // MOST_SAMPLES_ALONG))
    q, v, a = (np.stack([of(name) for name, _ in channels], axis=1) for of in (seen.value, seen.first, seen.second))
    omega, alpha = (np.stack([of(name) for _, name in channels], axis=1) for of in (seen.first, seen.second))
    return Along(q[::every], v[::every], a[::every], omega[::every], alpha[::every], every)


@dataclass(frozen=True, eq=False)
class Regressor:
    """``tau = W p``, row by row in time, and within one time joint by joint.

    Attributes:
        names: of the numbers p, ``<joint>.<number>``; see `BODY`, ``J`` of the rotor, `FRICTION`.
        columns: W (samples * n, numbers).
        values: p of the model (numbers,).
    """

    names: tuple[str, ...]
    columns: Array
    values: Array


def regressor(model: FlexibleJointModel, q: Array, v: Array, a: Array, omega: Array, alpha: Array) -> Regressor:
    """Columns of every number along a motion.

    The bodies are those of the tree: all links that are fixed to a joint are one body, in the frame of that joint. A
    joint that mimics another one acts on its leader: ``tau = G^T Y(G q + g0, G v, G a) phi``.

    Args:
        model: resolved.
        q: of the links (samples, n) [rad].
        v: likewise [rad/s].
        a: likewise [rad/s^2].
        omega: of the rotors (samples, n) [rad/s].
        alpha: likewise [rad/s^2].

    Returns:
        Columns of bodies, rotors, and friction (a level times the sign of omega).
    """
    tree, arm = model.robot.tree, model.robot.pin_model
    arm.gravity.linear = np.array(model.gravity)
    data = arm.createData()
    gain = tree.gain
    bodies = [
        gain.T @ np.atleast_2d(pin.computeJointTorqueRegressor(arm, data, *each))  # for one joint it is a vector
        for each in zip(q @ gain.T + tree.offset, v @ gain.T, a @ gain.T, strict=True)
    ]
    per_joint = np.stack([alpha, omega, np.sign(omega), np.ones_like(omega)], axis=2)
    joints = np.einsum("tjk,ij->tijk", per_joint, np.eye(model.n)).reshape(len(q) * model.n, -1)
    names = [f"{name}.{number}" for name in list(arm.names)[1:] for number in BODY]
    names += [f"{joint}.{number}" for joint in model.joint_names for number in ("J", *FRICTION)]
    values = np.concatenate([body_numbers(with_payloads(model.robot, model.all_effects)), *_joints(model)])
    return Regressor(tuple(names), np.hstack([np.concatenate(bodies), joints]), values)


def body_numbers(tree: Tree) -> Array:
    """The bodies' numbers (10 m,), in the order of `BODY`."""
    return np.ravel(tree.inertial_parameters[:, : len(BODY)])


def _joints(model: FlexibleJointModel) -> list[Array]:
    """J, viscous coefficient, Coulomb level and offset of every joint, with the friction of both sides added."""
    numbers = np.zeros((model.n, 4))
    numbers[:, 0] = model.rotor_inertia
    for effect in model.all_effects:
        if isinstance(effect, JointEffect) and effect.regressed:
            value = getattr(effect, effect.linear[0])
            on_the_left = -value if effect.stage == "actuator" else value
            numbers[model.index(effect.joint), 1 + FRICTION.index(effect.regressed)] += on_the_left
    return list(numbers)
