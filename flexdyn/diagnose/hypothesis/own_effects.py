"""A user's own effects as hypotheses: at all possible places, with the parameters in which they are linear."""

from __future__ import annotations

import dataclasses
import itertools
import math
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np

from flexdyn.diagnose.equations.equations import Equations
from flexdyn.diagnose.hypothesis.own_law import OwnLaw
from flexdyn.diagnose.hypothesis.proposal import Point, Proposal, extent_of
from flexdyn.effects import Effect, JointEffect, catalogue
from flexdyn.effects.extent import MotionExtent
from flexdyn.errors import InputError
from flexdyn.simulation.laws import PYTHON_STAGES

MOST_GRID_POINTS = 40
"""Largest number of points of a grid; of more, evenly spaced ones are used."""
AROUND = (1.0, 0.3, 3.0)
"""Values that are tried for a parameter with a default, as multiples of it [1]."""


def own_effects(equations: Equations) -> tuple[list[Proposal], list[str]]:
    """Proposals of all effect classes that users have defined, and a line for each that was left out."""
    found: list[Proposal] = []
    notes: list[str] = []
    for kind in catalogue().values():
        if kind.__module__.startswith("flexdyn."):
            continue
        try:
            found += _everywhere(_check_class(kind), equations)
        except InputError as error:
            notes.append(f"{kind.name}, an effect of your own, is not proposed: {error.problem}")
    return found, notes


def _check_class(kind: type[Effect]) -> type[JointEffect]:
    """Check that a diagnosis can propose effects of a class.

    Raises:
        InputError: it cannot; the message says why.
    """
    if not issubclass(kind, JointEffect) or kind.stage not in PYTHON_STAGES:
        raise InputError("it is no torque of stage friction, spring or actuator on a joint", key=kind.name)
    if kind.torque is Effect.torque:
        raise InputError("it has no law in Python", key=kind.name)
    numbers = {entry.name for entry in kind.parameters()} | {"joint", "side"}
    for entry in dataclasses.fields(kind):
        if entry.name not in numbers and entry.default is dataclasses.MISSING:
            raise InputError(f"it needs {entry.name}, which is no number", key=kind.name)
    return kind


def _everywhere(kind: type[JointEffect], equations: Equations) -> Iterator[Proposal]:
    """Proposals at every joint and side on which the effect can act."""
    model = equations.true
    for j, joint in enumerate(model.joint_names):
        sides = [str(side) for side in PYTHON_STAGES[kind.stage] if side in kind.sides]
        if not model.elastic[j]:  # link and motor side are the same
            sides = [side for side in sides if side != "transmission"][-1:]
        for side in sides:
            yield _proposal(kind, {"effect": kind.name, "joint": joint, "side": side}, equations, j)


def _proposal(kind: type[JointEffect], place: Mapping[str, str], equations: Equations, j: int) -> Proposal:
    """One class at one place.

    Raises:
        InputError: its law raises an error with all numbers that were tried.
    """
    law = OwnLaw(kind, place, equations, j)
    extent = extent_of(equations, j)
    grids = {entry.name: _values(entry, extent) for entry in kind.parameters()}
    points = [dict(zip(grids, numbers, strict=True)) for numbers in _thinned_grid(grids.values())]
    base = law.first_that_works(points)
    linear = law.linear_in(base)
    others = [name for name in grids if name not in linear]
    grid = [p for p in _thinned_grid([grids[name] for name in others]) if law.works(base | _by_name(others, p))]

    def build(point: Point, x: Sequence[float]) -> Effect | None:
        """The user's law with these numbers; None: it does not take them."""
        try:
            return law.effect(_by_name(others, point) | _by_name(linear, x))
        except InputError:  # out of its bounds
            return None

    lower = {entry.name: entry.metadata["lower"] for entry in kind.parameters()}
    positive, sizes = tuple(lower[name] >= 0.0 for name in linear), tuple(base[name] for name in linear)
    return Proposal(place, build, tuple(grid), positive, sizes)


def _by_name(names: Sequence[str], numbers: Sequence[float]) -> dict[str, float]:
    return dict(zip(names, numbers, strict=True))


def _thinned_grid(grids: Any) -> list[tuple[float, ...]]:
    """The product of grids; if it is large, evenly spaced points with the first one."""
    whole = list(itertools.product(*grids))
    return [whole[k] for k in np.unique(np.linspace(0, len(whole) - 1, min(MOST_GRID_POINTS, len(whole))).astype(int))]


def _values(entry: dataclasses.Field[Any], extent: MotionExtent) -> tuple[float, ...]:
    """Values to try for a parameter: multiples of its default, else scales of the joint in that unit."""
    unit, lower, strict = (entry.metadata[key] for key in ("unit", "lower", "strict"))
    if entry.default is not dataclasses.MISSING and math.isfinite(entry.default) and entry.default != 0.0:
        values = [entry.default * factor for factor in AROUND]
    elif entry.metadata["around"]:
        values = np.linspace(0.0, 2.0 * np.pi, 8, endpoint=False).tolist()
    elif unit in ("rad", "rad/s", "s"):
        size = {"rad": extent.span, "rad/s": extent.speed, "s": extent.seconds}[unit]
        values = (size * np.geomspace(0.01, 1.0, 5)).tolist()
        if unit == "rad" and lower < 0.0:
            values = np.linspace(extent.low, extent.high, 13)[1:-1].tolist()
    elif unit == "1":
        values = [*map(float, range(1, 9)), extent.ratio, 2.0 * extent.ratio]
    else:
        values = [extent.torque * factor for factor in (0.1, 0.03, 0.3)]
    kept = [float(v) for v in values if v > lower or (v == lower and not strict)]
    return tuple(kept) or (lower + 1.0,)
