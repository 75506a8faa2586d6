"""A user's own effects as hypotheses: at all possible places, with the parameters in which they are linear."""

from __future__ import annotations

import dataclasses
import itertools
import math
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np

from flexdyn.arrays import Array
from flexdyn.diagnose.equations.equations import Equations
from flexdyn.diagnose.equations.users_laws import torque_of
from flexdyn.diagnose.hypothesis.proposal import Point, Proposal, extent_of
from flexdyn.effects import Effect, JointEffect, catalogue
from flexdyn.effects.extent import MotionExtent
from flexdyn.errors import InputError
from flexdyn.simulation.laws import PYTHON_STAGES

LINEARITY_SAMPLES = 300
"""Number of samples of a motion that are used to test linearity."""
EQUAL_TORQUE_DIFFERENCE = 1e-7
"""Two torques with a smaller relative difference are equal [1]."""
MOST_GRID_POINTS = 40
"""Largest number of points of a grid; of more, evenly spaced ones are used."""
AROUND = (1.0, 0.3, 3.0)
"""Values that are tried for a parameter with a default, as multiples of it [1]."""


class Law:
    """A class of a user's effect at one place, along the measured motion.

    Args:
        kind: the class.
        place: ``joint`` and ``side``.
        equations: that have the motions.
        j: index of the joint.
    """

    def __init__(self, kind: type[JointEffect], place: Mapping[str, str], equations: Equations, j: int) -> None:
        self.kind, self.place = kind, place
        side = place["side"]
        x, u = {"link": ("q", "v"), "motor": ("theta", "omega"), "transmission": ("delta", "ddelta")}[side]
        motions = equations.motions
        columns = [np.concatenate([getattr(each, name)[:, j] for each in motions]) for name in (x, u, "tau")]
        self.whole = [*columns, np.concatenate([each.t for each in motions])]
        some = np.linspace(0, len(self.whole[0]) - 1, min(LINEARITY_SAMPLES, len(self.whole[0]))).astype(int)
        self.some = [column[some] for column in self.whole]

    def effect(self, numbers: Mapping[str, float]) -> JointEffect:
        """The effect with these parameters."""
        return self.kind(joint=self.place["joint"], side=self.place["side"], **numbers)  # type: ignore[arg-type]

    def added(self, numbers: Mapping[str, float], columns: Sequence[Array]) -> Array:
        """Its torque (samples,)."""
        x, u, tau, t = columns
        torque = torque_of(self.effect(numbers), x, u, t=t, tau=tau)
        return torque - tau if self.kind.stage == "actuator" else torque

    def works(self, numbers: Mapping[str, float]) -> bool:
        """Whether the law is finite along the whole motion."""
        try:
            self.added(numbers, self.whole)
        except InputError:
            return False
        return True

    def first_that_works(self, points: Sequence[dict[str, float]]) -> dict[str, float]:
        """The first grid point at which the torque is not zero, else one without an error.

        Raises:
            InputError: the law raises an error at all points; the message is that of the last one.
        """
        idle, failure = None, None
        for point in points:
            try:
                if self.added(point, self.some).any():
                    return point
                idle = idle or point
            except InputError as error:
                failure = error
        if idle is None and failure is not None:
            raise failure
        return idle or {}

    def linear_in(self, base: Mapping[str, float]) -> list[str]:
        """Parameters in which the torque is jointly linear: it adds up, scales, and is zero if they are 0."""
        chosen: list[str] = []
        for entry in self.kind.parameters():
            if self._is_linear([*chosen, entry.name], base):
                chosen.append(entry.name)
        return chosen

    def _is_linear(self, names: Sequence[str], base: Mapping[str, float]) -> bool:
        """Whether the torque is linear in these parameters, and each of them acts."""
        nothing = dict(base) | dict.fromkeys(names, 0.0)
        try:
            whole = self.added(base, self.some)
            twice = self.added(dict(base) | {name: 2.0 * base[name] for name in names}, self.some)
            alone = [self.added(nothing | {name: base[name]}, self.some) for name in names]
            rest = self.added(nothing, self.some)
        except InputError:
            return False
        size = EQUAL_TORQUE_DIFFERENCE * float(np.abs(whole).max())
        off = max(float(np.abs(each).max()) for each in (np.sum(alone, axis=0) - whole, twice - 2.0 * whole, rest))
        acting = all(np.abs(each).max() > size for each in alone)
        return size > 0.0 and acting and off < size


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
    law = Law(kind, place, equations, j)
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
