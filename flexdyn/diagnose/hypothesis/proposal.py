"""A hypothesis of one effect at one place: its linear parameters are free, the others are on a grid."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from flexdyn.diagnose.equations.equations import Equations
from flexdyn.effects import Effect, effect_from_dict

Array = NDArray[np.float64]
Point = tuple[float, ...]
Unit = tuple[Effect, float]


@dataclass(frozen=True, eq=False)
class Proposal:
    """One effect at one place.

    Attributes:
        place: ``effect``, ``joint``, ``side`` or ``channel``, and further keys of its place.
        make: the effect from a grid point and the linear values; None if they are not allowed.
        units: effects at a grid point, one for each linear parameter, each with the size of that parameter in it.
        grid: points of the nonlinear parameters; one empty point if there are none.
        positive: whether each linear value must not be negative.
        fixed: no parameter is linear: the effect at the grid point is used as it is.
        axes: names of the parameters of the grid.
    """

    place: Mapping[str, str]
    make: Callable[[Point, Array], Effect | None]
    units: Callable[[Point], Sequence[Unit]]
    grid: tuple[Point, ...] = ((),)
    positive: tuple[bool, ...] = ()
    fixed: bool = False
    axes: tuple[str, ...] = ()

    @property
    def joint(self) -> str:
        """The joint that it acts on, directly or by a channel; empty if it does not act on one joint."""
        return self.place.get("joint") or self.place.get("channel", "").partition(".")[2]

    def is_of(self, effect: Effect) -> bool:
        """Whether an effect is of this kind at this place."""
        return all(getattr(effect, "name" if key == "effect" else key, None) == it for key, it in self.place.items())


@dataclass(frozen=True)
class MotionExtent:
    """Scales of a joint's motion in the data, for the grids.

    Attributes:
        speed: nearly the largest speed of the rotor [rad/s].
        span: range of the rotor's position [rad].
        deflection: nearly the largest one, 0 for a rigid joint [rad].
        torque: the largest commanded torque [N m].
        given: nearly the largest torque that the motion needs according to the model, at most `torque` [N m].
        seconds: duration of the longest recording [s].
        low, high: ends of the link's range [rad].
        ratio: of the gear [1].
        turns: whether the joint is revolute, so that effects may be periodic over a turn.
    """

    speed: float
    span: float
    deflection: float
    torque: float
    given: float
    seconds: float
    low: float
    high: float
    ratio: float
    turns: bool = True

    @classmethod
    def of(cls, equations: Equations, j: int) -> MotionExtent:
        """The scales of one joint over all recordings."""
        omega, theta, delta, tau, q = (
            np.concatenate([getattr(m, name)[:, j] for m in equations.motions])
            for name in ("omega", "theta", "delta", "tau", "q")
        )
        needed = np.concatenate([equations.needed(along, j) for along in equations.motions])
        asked = max(float(np.abs(tau).max()), 1e-9)
        wound = float(np.percentile(np.abs(delta - np.median(delta)), 99.5)) if equations.true.elastic[j] else 0.0
        if equations.replayed[j]:  # a model that lacks what loads the spring does not wind it
            wound = max(wound, float(np.percentile(np.abs(tau), 99.5) / equations.true.stiffness[j]))
        return cls(
            speed=max(float(np.percentile(np.abs(omega), 99.0)), 1e-9),
            span=max(float(np.ptp(theta)), 1e-9),
            deflection=max(wound, 1e-9),
            torque=asked,
            given=max(min(float(np.percentile(np.abs(needed), 99.5)), asked), 1e-6 * asked),
            seconds=max(float(m.t[-1] - m.t[0]) for m in equations.motions),
            low=float(q.min()),
            high=float(q.max()),
            ratio=abs(float(equations.true.joints[equations.true.joint_names[j]].gear_ratio)),
            turns=equations.true.robot.kinds[j] != "prismatic",
        )


def at(place: Mapping[str, str], **numbers: float) -> Effect:
    """The effect at a place with these numbers."""
    entry: dict[str, Any] = {**place, **numbers}
    return effect_from_dict(entry)


def linear(
    place: Mapping[str, str], name: str, grid: Sequence[Mapping[str, float]] = ({},), *, unit: float = 1.0
) -> Proposal:
    """An effect with one linear parameter, which may not be negative if its bound says so."""

    def build(point: Point, value: float) -> Effect:
        return at(place, **{name: value}, **dict(zip(grid[0], point, strict=True)))

    points = tuple(tuple(float(number) for number in entry.values()) for entry in grid)
    bounds = {entry.name: entry.metadata["lower"] for entry in build(points[0], unit).parameters()}
    return Proposal(
        place,
        make=lambda point, values: build(point, float(values[0])),
        units=lambda point: [(build(point, unit), unit)],
        grid=points,
        positive=(bounds[name] >= 0.0,),
        axes=tuple(grid[0]),
    )


def declared(
    kind: type[Effect], place: Mapping[str, str], extent: MotionExtent, beside: Collection[str] = ()
) -> Proposal:
    """An effect with the linear parameters and the grids that its class declares.

    Its linear parameters may not be negative if their bound says so. They may also not be negative if the model lacks
    the plainer law that a negative parameter would need.

    Args:
        kind: its class.
        place: ``joint`` and ``side``.
        extent: scales of the joint, for the grids.
        beside: effects of the model at this place.
    """
    place, names = {"effect": kind.name, **place}, tuple(kind.grids)
    sizes = {"one": 1.0, **{key: getattr(extent, key) for key in ("given", "speed", "deflection", "seconds")}}
    values = [[share * sizes[scale] for share in shares] for scale, shares in kind.grids.values()]
    grid = tuple(itertools.product(*values))
    if not kind.linear:
        return given(place, names, grid)
    lower = {entry.name: entry.metadata["lower"] for entry in kind.parameters()}
    alone = bool(kind.plainer) and not set(kind.plainer) & set(beside)

    def build(point: Point, x: Sequence[float]) -> Effect:
        return at(place, **dict(zip(names, point, strict=True)), **dict(zip(kind.linear, x, strict=True)))

    return Proposal(
        place,
        make=lambda point, x: build(point, x.tolist()),
        units=lambda point: [(build(point, row), 1.0) for row in np.eye(len(kind.linear)).tolist()],
        grid=grid,
        positive=tuple(lower[name] >= 0.0 or alone for name in kind.linear),
        axes=names,
    )


def wave(place: Mapping[str, str], harmonics: Sequence[float], unit: float) -> Proposal:
    """``amplitude sin(harmonic x + phase)``: linear in its sine and cosine parts."""

    def build(point: Point, amplitude: float, phase: float) -> Effect:
        return at(place, amplitude=amplitude, harmonic=point[0], phase=phase)

    return Proposal(
        place,
        make=lambda point, x: build(point, float(np.hypot(x[0], x[1])), math.atan2(x[1], x[0])),
        units=lambda point: [(build(point, unit, 0.0), unit), (build(point, unit, math.pi / 2), unit)],
        grid=tuple((float(h),) for h in harmonics),
        axes=("harmonic",),
    )


def given(place: Mapping[str, str], names: Sequence[str], grid: Sequence[Point]) -> Proposal:
    """An effect without linear parameters, at the points of a grid."""

    def build(point: Point) -> Effect:
        return at(place, **dict(zip(names, point, strict=True)))

    return Proposal(
        place,
        make=lambda point, values: build(point),
        units=lambda point: [(build(point), 1.0)],
        grid=tuple(grid),
        fixed=True,
        axes=tuple(names),
    )
