"""Poses and states from users, as checked arrays."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np
from numpy.typing import ArrayLike

from flexdyn.arrays import Array
from flexdyn.checks import as_numbers
from flexdyn.errors import InputError, did_you_mean
from flexdyn.model.flexible_joint_model import FlexibleJointModel

Pose = ArrayLike | Mapping[str, float] | None


def pose(model: FlexibleJointModel, q: Pose, key: str = "q") -> Array:
    """Link positions (n,) [rad or m].

    Args:
        model: whose joints they are.
        q: (n,), or by joint, with the model's `initial` for the others; None: the model's `initial`, else 0.
        key: name of the argument in errors.

    Raises:
        InputError: another number of joints, an unknown joint, a number that is not finite.
    """
    names, known = model.joint_names, model.initial.get("q", {})
    if q is None or isinstance(q, Mapping):
        for joint in q or {}:
            if joint not in names:
                remedy = did_you_mean(str(joint), names)
                raise InputError("the robot has no such joint", key=f"{key}.{joint}", remedy=remedy)
        q = [{**known, **(q or {})}.get(joint, 0.0) for joint in names]
    return vector(q, model.n, key, f"one number for each of {', '.join(names)}")


def vector(value: ArrayLike, size: int, key: str, remedy: str) -> Array:
    """`size` finite numbers, copied.

    Raises:
        InputError: they are not.
    """
    try:
        array = as_numbers(value)
    except (TypeError, ValueError, OverflowError):
        raise InputError("numbers are needed", key=key, value=value, remedy=remedy) from None
    if array.shape != (size,) or not np.isfinite(array).all():
        raise InputError(f"{size} finite numbers are needed", key=key, value=value, remedy=remedy)
    return array


def torques(model: FlexibleJointModel, tau: ArrayLike | Mapping[str, float]) -> Array:
    """Commanded motor torques (n,) [N m or N]; a mapping names some joints, the others get 0.

    Raises:
        InputError: another number of joints, an unknown joint, a number that is not finite.
    """
    names = model.joint_names
    if isinstance(tau, Mapping):
        for joint in tau:
            if joint not in names:
                remedy = did_you_mean(str(joint), names)
                raise InputError("the robot has no such joint", key=f"tau.{joint}", remedy=remedy)
        tau = [tau.get(joint, 0.0) for joint in names]
    return vector(tau, model.n, "tau", f"one number for each of {', '.join(names)}")


def checked_frequencies(frequencies: ArrayLike) -> Array:
    """Frequencies (f,) [Hz], at least 0.

    Raises:
        InputError: something else.
    """
    try:
        array = np.atleast_1d(as_numbers(frequencies))
    except (TypeError, ValueError, OverflowError):
        array = np.array([math.nan])
    if array.ndim != 1 or not np.isfinite(array).all() or (array < 0).any():
        raise InputError("frequencies in Hz, at least 0, are needed", key="frequencies", value=frequencies)
    return array
