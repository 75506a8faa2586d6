"""Checks of a command's settings: interpolation, feedback, rate, numbers for each joint."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, Literal

import numpy as np

from flexdyn.checks import Array, as_numbers, check_known, number
from flexdyn.errors import InputError

Interpolation = Literal["hold", "linear", "monotone", "cubic"]
INTERPOLATIONS = ("hold", "linear", "monotone", "cubic")


def check_interpolation(key: str, given: Any) -> None:
    """Check how a command is interpolated.

    Args:
        key: of the setting, for the message.
        given: its value.

    Raises:
        InputError: there is no such interpolation.
    """
    remedy = f"it is {', '.join(INTERPOLATIONS)}"
    check_known(given, INTERPOLATIONS, "no such interpolation", key=key, value=given, remedy=remedy)


def check_feedback(key: str, given: Any) -> None:
    """Check from which side of the joints a controller gets its positions.

    Args:
        key: of the setting, for the message.
        given: its value.

    Raises:
        InputError: it is neither.
    """
    check_known(given, ("theta", "q"), "no such feedback", key=key, value=given, remedy="it is theta or q")


def checked_rate(key: str, rate: Any) -> float:
    """Check a rate in Hz: finite and above 0.

    Raises:
        InputError: it is not.
    """
    return number(key, rate, "a rate above 0 Hz is needed", above=0.0)


def per_joint(key: str, value: Any, joint_names: Sequence[str]) -> Array:
    """One number for all joints, one per joint, or a mapping by joint, as (n,).

    Args:
        key: of the setting, for the message.
        value: as given.
        joint_names: in the order of the result.

    Raises:
        InputError: wrong length, an unknown or missing joint, a number that is not finite.
    """
    n = len(joint_names)
    if isinstance(value, Mapping):
        for joint in value:
            remedy = f"the joints are {', '.join(joint_names)}"
            check_known(joint, joint_names, "the robot has no such joint", key=f"{key}.{joint}", remedy=remedy)
        for joint in joint_names:
            if joint not in value:
                raise InputError("a joint is missing", key=f"{key}.{joint}", remedy="give it a number, 0 for none")
        value = [value[joint] for joint in joint_names]
    array = as_numbers(key, value)
    if array.ndim > 1 or (array.ndim == 1 and len(array) != n):
        raise InputError(f"one number, or one for each of the {n} joints, is needed", key=key, value=array.shape)
    if not np.isfinite(array).all():
        raise InputError("finite numbers are needed", key=key, value=value)
    return np.array(np.broadcast_to(array, (n,)))
