"""The first state of a run: from arguments, over a recording's first row, over the model's own."""

from __future__ import annotations

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
    values = {
        signal: _start(model, signal, given[signal], {**model.initial.get(signal, {}), **drive.initial.get(signal, {})})
        for signal in ("q", "v", "theta", "omega")
    }
    for rotor, link in (("theta", "q"), ("omega", "v")):  # a link put elsewhere takes its rotor along
        if given[rotor] is None and given[link] is not None:
            values[rotor][_named(model, given[link])] = math.nan
    q, v = (np.nan_to_num(values[signal], nan=0.0) for signal in ("q", "v"))
    theta = np.where(np.isnan(values["theta"]), q, values["theta"])
    omega = np.where(np.isnan(values["omega"]), v, values["omega"])
    if isinstance(given["theta"], str):
        theta = equilibrium_theta(model, q)
    for signal, turned, moved in (("theta", theta, q), ("omega", omega, v)):
        different = ~model.elastic & (turned != moved)
        if different.any():
            joint = model.joint_names[int(np.argmax(different))]
            twin = {"theta": "q", "omega": "v"}[signal]
            problem = f"the joint is rigid: {signal} is {twin}"
            raise InputError(problem, key=f"{signal}0.{joint}", value=float(turned[model.index(joint)]))
    return np.concatenate([q, theta[model.elastic], v, omega[model.elastic]])


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


def _start(model: FlexibleJointModel, signal: str, given: Any, known: Mapping[str, float]) -> Array:
    """One signal of the first state (n,), NaN where nothing is said."""
    names, key = model.joint_names, f"{signal}0"
    start = np.array([known.get(joint, math.nan) for joint in names])
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
    return array


def _number(key: str, value: Any) -> float:
    number = as_number(value)
    if not math.isfinite(number):
        raise InputError("a finite number is needed", key=key, value=value)
    return number
