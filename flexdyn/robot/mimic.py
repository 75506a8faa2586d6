"""Mimic joints: chains are resolved to the one joint that leads, and locked leaders to a value."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

from flexdyn.checks import check_known, number
from flexdyn.errors import InputError

Mimic = tuple[str, float, float]
"""Leader, multiplier, offset: q_follower = multiplier * q_leader + offset."""


def resolve_mimics(
    mimics: Mapping[str, Mimic], held: Mapping[str, float], moving: Sequence[str]
) -> tuple[dict[str, Mimic], dict[str, float]]:
    """Refer every follower to an independent joint.

    Args:
        mimics: the joint that each follower mimics, as written; it may be a follower too.
        held: positions [rad or m] of joints that do not move: fixed ones (0) and locked ones.
        moving: names of all other joints, followers included.

    Returns:
        The followers with their independent leaders, and the positions of those whose leader does not move.

    Raises:
        InputError: an unknown leader, a joint that mimics itself, or a loop.
    """
    followers: dict[str, Mimic] = {}
    still: dict[str, float] = {}
    known = {*held, *moving}
    for follower in mimics:
        gain, offset, at, chain = 1.0, 0.0, follower, [follower]
        while at in mimics:
            leader, multiplier, shift = mimics[at]
            key = f"joint '{at}'/mimic"
            if leader == at:
                raise InputError("the joint mimics itself", key=key, remedy="name the joint that leads it")
            if leader in chain:
                loop = " -> ".join([*chain[chain.index(leader) :], leader])
                raise InputError(f"mimics form a loop: {loop}", key=key, remedy="one joint of them must lead")
            check_known(leader, sorted(known - {at}), "mimics an unknown joint", key=key, value=leader)
            offset += gain * shift
            gain *= multiplier
            at = leader
            chain.append(at)
        if not (math.isfinite(gain) and math.isfinite(offset)):
            remedy = "check the multipliers of its leaders"
            raise InputError("the mimic overflows", key=f"joint '{follower}'/mimic", remedy=remedy)
        if at in held or gain == 0.0:
            still[follower] = gain * held.get(at, 0.0) + offset
        else:
            followers[follower] = (at, gain, offset)
    return followers, still


def check_lock(
    lock: Mapping[str, Any] | None, moving: Sequence[str], mimics: Mapping[str, Mimic], fixed: Sequence[str]
) -> dict[str, float]:
    """The joints to lock and their positions, as the user gave them.

    Args:
        lock: position [rad or m] by joint name.
        moving: names of the joints that move, followers included.
        mimics: the joint that each follower mimics.
        fixed: names of the fixed joints.

    Returns:
        A plain dict of floats.

    Raises:
        InputError: not a mapping, an unknown or fixed joint, a follower, or no finite number.
    """
    if lock is None:
        return {}
    if not isinstance(lock, Mapping):
        raise InputError("not a table", key="lock", value=lock, remedy="write it like {joint7: 0.0}")
    checked = {}
    for joint, value in lock.items():
        key = f"lock.{joint}"
        if joint in fixed:
            raise InputError("the joint is fixed already", key=key, remedy="leave it out")
        if joint in mimics and joint in moving:
            remedy = f"lock its leader '{mimics[joint][0]}'"
            raise InputError("the joint mimics another and cannot be locked alone", key=key, remedy=remedy)
        if joint not in moving:
            check_known(joint, [name for name in moving if name not in mimics], "no such joint", key=key)
        checked[joint] = number(key, value, "not a finite number", remedy="give the position in rad or m")
    return checked
