"""The first state of a run: from the arguments, else from a recording's first row, else from the model."""

from __future__ import annotations

import itertools
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from flexdyn.checks import Array, as_numbers, number
from flexdyn.errors import InputError
from flexdyn.model.flexible_joint_model import FlexibleJointModel
from flexdyn.simulation.command_input import Drive
from flexdyn.simulation.link_side import LinkSide

Start = ArrayLike | Mapping[str, float] | None
Columns = Mapping[str, Mapping[str, Any]]


def first_state(model: FlexibleJointModel, drive: Drive, given: Mapping[str, Any]) -> Array:
    """X = [q, theta, v, omega] from the arguments, else the recording's first row, else the model's `initial`."""
    checked = {signal: _checked(model, signal, value) for signal, value in given.items()}
    return np.array(_entries(model, drive, model.initial, checked, isinstance(given["theta"], str)))


def first_states(model: FlexibleJointModel, drive: Drive, initial: Columns, given: Columns, runs: int) -> Array:
    """The first states of many runs (runs, 2 (n + e)) with e elastic joints, each as from `first_state`.

    Args:
        model: the arm.
        drive: the prepared command.
        initial: instead of the model's own: signal -> joint -> a number, or a column of them (runs,).
        given: likewise the arguments q0, v0, theta0, omega0 of `simulate`; every number is finite.
        runs: number of runs.

    Raises:
        InputError: the rotor of a rigid joint starts at another position than its link.
    """
    placed = {
        signal: {model.index(joint): value for joint, value in given[signal].items()} if signal in given else None
        for signal in ("q", "v", "theta", "omega")
    }
    entries = _entries(model, drive, initial, placed, False)
    return np.stack([np.broadcast_to(entry, runs) for entry in entries], axis=1)


def _entries(
    model: FlexibleJointModel, drive: Drive, initial: Columns, given: Mapping[str, Any], balanced: bool
) -> list[Any]:
    """The first state, each entry a number or a column of them; `given` is by the index of the joint."""
    links, rotors = [], []
    elastic = model.elastic.tolist()
    for link, rotor in (("q", "theta"), ("v", "omega")):
        moved, turned = (
            _over(model, given[signal], drive.initial.get(signal, {}), initial.get(signal, {}))
            for signal in (link, rotor)
        )
        if given[rotor] is None and given[link] is not None:  # the rotor starts with its link
            for j in given[link]:
                turned[j] = None
        moved = [0.0 if x is None else x for x in moved]
        turned = [x if y is None else y for x, y in zip(moved, turned, strict=True)]
        if balanced and rotor == "theta":
            turned = equilibrium_theta(model, np.array(moved)).tolist()
        for j, soft in enumerate(elastic):
            if not soft and turned[j] is not moved[j] and np.any(turned[j] != moved[j]):
                key = f"{rotor}0.{model.joint_names[j]}"
                raise InputError(f"the joint is rigid: {rotor} is {link}", key=key, value=turned[j])
        links.append(moved)
        rotors.append(itertools.compress(turned, elastic))
    return [*links[0], *rotors[0], *links[1], *rotors[1]]


def _over(
    model: FlexibleJointModel, given: Mapping[int, Any] | None, measured: Mapping[str, Any], own: Mapping[str, Any]
) -> list[Any]:
    """One signal of the first state (n,): the given one, else the measured one, else the model's own; else None."""
    start = [measured.get(joint, own.get(joint)) for joint in model.joint_names]
    for j, value in (given or {}).items():
        start[j] = value
    return start


def equilibrium_theta(model: FlexibleJointModel, q: Array) -> Array:
    """Rotor positions (n,) at which the springs carry gravity at rest: K (theta - q) = h(q, 0)."""
    weight = LinkSide(model).bias(q, np.zeros(model.n))
    elastic = model.elastic
    theta = q.copy()
    theta[elastic] += weight[elastic] / model.resolved().stiffness[elastic]
    return theta


def _checked(model: FlexibleJointModel, signal: str, given: Any) -> dict[int, float] | None:
    """The given values of one signal, by the index of the joint; None if there are none."""
    key = f"{signal}0"
    if given is None:
        return None
    if isinstance(given, str):
        if signal == "theta" and given == "equilibrium":
            return {}
        raise InputError("numbers are needed", key=key, value=given, remedy="give one for each joint")
    if isinstance(given, Mapping):
        return {model.index(joint): number(f"{key}.{joint}", value) for joint, value in given.items()}
    array = as_numbers(key, given)
    if array.shape != (model.n,) or not np.isfinite(array).all():
        remedy = f"the joints are {', '.join(model.joint_names)}"
        raise InputError(f"{model.n} finite numbers are needed", key=key, value=given, remedy=remedy)
    return dict(enumerate(array.tolist()))
