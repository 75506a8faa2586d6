"""Couplings of a channel map: motors that move several joints together, as in differential wrists."""

from __future__ import annotations

import math
from collections.abc import Collection, Iterable, Sequence
from typing import Any

import numpy as np

from flexdyn.checks import Array, as_number, check_known
from flexdyn.errors import InputError
from flexdyn.io.yaml import check_keys
from flexdyn.records.channelmap.description import Channel, Coupling

KEYS = ("joints", "position", "torque", "signals")
MOTIONS = ("q", "v", "theta", "omega")
TORQUES = ("tau", "tau_applied")
_SINGULAR = 1e12

Matrix = tuple[tuple[float, ...], ...]


def couplings_of(entries: Any, channels: Sequence[Channel]) -> tuple[Coupling, ...]:
    """The couplings that a map file lists.

    Raises:
        InputError: a joint without channels or in two couplings, or matrices that do not fit.
    """
    if not isinstance(entries, list):
        raise InputError("a list of couplings is needed", key="couplings", value=entries)
    names = {channel.name for channel in channels}
    joints = tuple(dict.fromkeys(channel.joint for channel in channels if channel.signal))
    made: list[Coupling] = []
    for i, entry in enumerate(entries):
        key = f"couplings[{i}]"
        check_keys(entry, KEYS, required=("joints", "position"), key=key)
        made.append(_coupling(key, entry, joints, [joint for coupling in made for joint in coupling.joints]))
        _check_complete(key, made[-1], names)
    return tuple(made)


def couple(columns: dict[str, Array], couplings: Iterable[Coupling]) -> None:
    """Replace the motors' values in the columns by the joints'."""
    for coupling in couplings:
        pairs = [(signal, coupling.position) for signal in coupling.signals]
        pairs += [(signal, coupling.torque) for signal in TORQUES]
        for signal, matrix in pairs:
            names = [f"{signal}.{joint}" for joint in coupling.joints]
            if names[0] in columns:
                motors = [columns[name] for name in names]
                for name, row in zip(names, matrix, strict=True):
                    columns[name] = sum((a * x for a, x in zip(row, motors, strict=True)), np.zeros(len(motors[0])))


def _coupling(key: str, entry: Any, known: Sequence[str], taken: Collection[str]) -> Coupling:
    """A coupling; without a matrix of torques it follows from the positions, as power is the same on both sides."""
    joints = _words(f"{key}.joints", entry["joints"], known)
    if len(joints) < 2:
        raise InputError("two joints or more are needed", key=f"{key}.joints", value=entry["joints"])
    for joint in joints:
        if joint in taken:
            remedy = "give one matrix for all joints that are coupled"
            raise InputError("the joint is in two couplings", key=f"{key}.joints", value=joint, remedy=remedy)
    position = _matrix(f"{key}.position", entry["position"], len(joints))
    signals = _words(f"{key}.signals", entry.get("signals", ["theta", "omega"]), MOTIONS)
    if "torque" in entry:
        return Coupling(joints, position, _matrix(f"{key}.torque", entry["torque"], len(joints)), signals)
    if np.linalg.cond(position) > _SINGULAR:
        remedy = "correct it, or give torque as well"
        raise InputError("the matrix is singular", key=f"{key}.position", value=entry["position"], remedy=remedy)
    return Coupling(joints, position, tuple(tuple(row) for row in np.linalg.inv(position).T.tolist()), signals)


def _check_complete(key: str, coupling: Coupling, names: Collection[str]) -> None:
    """Check that a signal is mapped for all joints of a coupling or for none, and that at least one is."""
    found = False
    for signal in (*coupling.signals, *TORQUES):
        there = [f"{signal}.{joint}" in names for joint in coupling.joints]
        if any(there) and not all(there):
            missing = f"{signal}.{coupling.joints[there.index(False)]}"
            raise InputError("a coupled channel is missing", key=f"{key}.joints", value=missing, remedy="map it too")
        found = found or all(there)
    if not found:
        remedy = f"map one of {', '.join((*coupling.signals, *TORQUES))} for its joints, or say which in signals"
        raise InputError("no channel of the coupled joints is mapped", key=key, remedy=remedy)


def _words(key: str, value: Any, known: Sequence[str]) -> tuple[str, ...]:
    """Known words, none of them twice."""
    if not isinstance(value, list) or len(set(map(str, value))) != len(value):
        raise InputError("a list without repetition is needed", key=key, value=value)
    for word in value:
        check_known(word, known, "no such name", key=key, value=word)
    return tuple(value)


def _matrix(key: str, value: Any, size: int) -> Matrix:
    """A square matrix with one row for each joint."""
    rows = value if isinstance(value, list) and all(isinstance(row, list) for row in value) else []
    if len(rows) != size or any(len(row) != size for row in rows):
        raise InputError(f"a matrix of {size} rows of {size} numbers is needed", key=key, value=value)
    numbers = tuple(tuple(as_number(entry) for entry in row) for row in rows)
    if not all(math.isfinite(entry) for row in numbers for entry in row):
        raise InputError("finite numbers are needed", key=key, value=value)
    return numbers
