"""Names of states and outputs, and the matrix C that picks outputs from a state."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from flexdyn.arrays import Array
from flexdyn.errors import InputError, did_you_mean
from flexdyn.model.flexible_joint_model import FlexibleJointModel

SIGNALS = ("q", "theta", "v", "omega", "deflection")


def state_names(model: FlexibleJointModel, size: int) -> tuple[str, ...]:
    """Channel of every entry of a state of `size` entries; internal states of effects are ``z[i]``."""
    links = model.joint_names
    rotors = [joint for joint, elastic in zip(links, model.elastic, strict=True) if elastic]
    names = [
        f"{signal}.{joint}" for signal, joints in zip(SIGNALS, (links, rotors) * 2, strict=False) for joint in joints
    ]
    return (*names, *(f"z[{i}]" for i in range(size - len(names))))


def output_matrix(model: FlexibleJointModel, size: int, outputs: Sequence[str]) -> tuple[tuple[str, ...], Array]:
    """Names of the outputs and C (outputs, nx).

    Args:
        model: whose joints they are.
        size: nx.
        outputs: signals of every joint, or single channels ``signal.joint``. A rigid joint reads theta as q.

    Raises:
        InputError: an unknown signal or joint.
    """
    if isinstance(outputs, str):
        outputs = (outputs,)
    names = []
    for output in outputs:
        signal, _, joint = str(output).partition(".")
        if signal not in SIGNALS:
            raise InputError("no such signal", key="outputs", value=output, remedy=did_you_mean(signal, SIGNALS))
        names += [
            f"{signal}.{each}" for each in ((model.joint_names[model.index(joint)],) if joint else model.joint_names)
        ]
    return tuple(names), np.array([_row(model, size, *name.split(".", 1)) for name in names]).reshape(len(names), size)


def _row(model: FlexibleJointModel, size: int, signal: str, joint: str) -> Array:
    j, n = model.index(joint), model.n
    half = n + int(model.elastic.sum())
    elastic = bool(model.elastic[j])
    rotor = n + int(model.elastic[:j].sum()) if elastic else j
    if signal == "deflection":
        row = np.zeros(size)
        row[rotor] += 1.0
        row[j] -= 1.0
        return row
    place = {"q": j, "theta": rotor, "v": half + j, "omega": half + rotor}[signal]
    return np.asarray(np.eye(size)[place])
