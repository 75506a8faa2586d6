"""Poses and states from users, as checked arrays."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import ArrayLike

from flexdyn.arrays import Array
from flexdyn.checks import as_numbers, check_known
from flexdyn.errors import InputError
from flexdyn.model.flexible_joint_model import FlexibleJointModel

ByJoint = ArrayLike | Mapping[str, float]
Pose = ByJoint | None


def pose(model: FlexibleJointModel, q: Pose, key: str = "q") -> Array:
    """Link positions (n,) [rad or m].

    Args:
        model: whose joints they are.
        q: (n,), or by joint, with the model's `initial` for the others; None: the model's `initial`, else 0.
        key: name of the argument in errors.

    Raises:
        InputError: another number of joints, an unknown joint, a number that is not finite.
    """
    return _of_joints(model, {} if q is None else q, key, model.initial.get("q", {}))


def vector(value: ArrayLike, size: int, key: str, remedy: str) -> Array:
    """`size` finite numbers, copied.

    Raises:
        InputError: they are not.
    """
    array = as_numbers(key, value, remedy=remedy)
    if array.shape != (size,) or not np.isfinite(array).all():
        raise InputError(f"{size} finite numbers are needed", key=key, value=value, remedy=remedy)
    return array


def torques(model: FlexibleJointModel, tau: ByJoint) -> Array:
    """Commanded motor torques (n,) [N m or N]; a mapping names some joints, the others get 0.

    Args:
        model: of the arm.
        tau: by joint, or in the order of the joints.

    Raises:
        InputError: another number of joints, an unknown joint, a number that is not finite.
    """
    return _of_joints(model, tau, "tau", {})


def _of_joints(model: FlexibleJointModel, given: ByJoint, key: str, others: Mapping[str, float]) -> Array:
    """One number for each joint (n,), from all of them or by joint; `others` has those that are not named, else 0."""
    names = model.joint_names
    if isinstance(given, Mapping):
        for joint in given:
            check_known(joint, names, "the robot has no such joint", key=f"{key}.{joint}")
        given = [{**others, **given}.get(joint, 0.0) for joint in names]
    return vector(given, model.n, key, f"one number for each of {', '.join(names)}")


def checked_frequencies(frequencies: ArrayLike) -> Array:
    """Frequencies (f,) [Hz], at least 0.

    Raises:
        InputError: something else.
    """
    problem = "frequencies in Hz, at least 0, are needed"
    array = np.atleast_1d(as_numbers("frequencies", frequencies, problem))
    if array.ndim != 1 or not np.isfinite(array).all() or (array < 0).any():
        raise InputError(problem, key="frequencies", value=frequencies)
    return array
