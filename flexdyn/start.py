"""The first state of a run: from arguments, over a recording's first row, over the model's own."""

from __future__ import annotations

import itertools
import math
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from flexdyn.checks import as_number
from flexdyn.drive import Drive
from flexdyn.errors import InputError
from flexdyn.model import FlexibleJointModel
from flexdyn.plant import LinkSide

Array = NDArray[np.float64]
Start = ArrayLike | Mapping[str, float] | None


def first_state(model: FlexibleJointModel, drive: Drive, given: dict[str, Any]) -> Array:
    """X = [q, theta, v, omega] from the arguments, over the recording's first row, over the model's `initial`."""
    links, rotors = [], []
    elastic = model.elastic.tolist()
    for link, rotor in (("q", "theta"), ("v", "omega")):
        moved = [0.0 if math.isnan(x) else x for x in _start(model, drive, link, given[link])]
        turned = _start(model, drive, rotor, given[rotor])
        if given[rotor] is None and given[link] is not None:  # a link put elsewhere takes its rotor along
            for j in _named(model, given[link]):
                turned[j] = math.nan
        turned = [x if math.isnan(y) else y for x, y in zip(moved, turned, strict=True)]
        if isinstance(given[rotor], str):
            turned = equilibrium_theta(model, np.array(moved)).tolist()
        for j, soft in enumerate(elastic):
            if not soft and turned[j] != moved[j]:
                key = f"{rotor}0.{model.joint_names[j]}"
                raise InputError(f"the joint is rigid: {rotor} is {link}", key=key, value=turned[j])
        links.append(moved)
        rotors.append(itertools.compress(turned, elastic))
    return np.array([*links[0], *rotors[0], *links[1], *rotors[1]])


def _named(model: FlexibleJointModel, given: Start) -> list[int]:
    """Joints that a first state was given for."""
    return [model.index(joint) for joint in given] if isinstance(given, Mapping) else list(range(model.n))


def equilibrium_theta(model: FlexibleJointModel, q: Array) -> Array:
    """Rotor positions (n,) at which the springs carry gravity at rest: K (theta - q) = h(q, 0)."""
    weight = LinkSide(model).bias(q, np.zeros(model.n))
    elastic = model.elastic
    theta = q.copy()
    theta[elastic] += weight[elastic] / model.resolved().stiffness[elastic]
    return theta


def _start(model: FlexibleJointModel, drive: Drive, signal: str, given: Any) -> list[float]:
    """One signal of the first state (n,), NaN where nothing is said."""
    names, key = model.joint_names, f"{signal}0"
    known = {**model.initial.get(signal, {}), **drive.initial.get(signal, {})}
    start = [known.get(joint, math.nan) for joint in names]
    if given is None:
        return start
    if isinstance(given, str):
        if signal == "theta" and given == "equilibrium":
            return start
        raise InputError("numbers are needed", key=key, value=given, remedy="give one for each joint")
    if isinstance(given, Mapping):
        for joint, value in given.items():
            start[model.index(joint)] = _number(f"{key}.{joint}", value)
        return start
    try:
        array = np.array(given, dtype=float)
    except (TypeError, ValueError, OverflowError):
        raise InputError("numbers are needed", key=key, value=given) from None
    if array.shape != (model.n,) or not np.isfinite(array).all():
        remedy = f"the joints are {', '.join(names)}"
        raise InputError(f"{model.n} finite numbers are needed", key=key, value=given, remedy=remedy)
    return list(array.tolist())


def _number(key: str, value: Any) -> float:
    number = as_number(value)
    if not math.isfinite(number):
        raise InputError("a finite number is needed", key=key, value=value)
    return number
