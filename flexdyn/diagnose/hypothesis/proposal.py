"""A hypothesis of one effect at one place: its linear parameters are free, the others are on a grid."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from flexdyn.arrays import Array
from flexdyn.diagnose.equations.computed_positions import friction_of
from flexdyn.diagnose.equations.equations import Equations
from flexdyn.diagnose.equations.motion import SmoothedMotion
from flexdyn.diagnose.equations.terms import joint_terms
from flexdyn.diagnose.lazy import kept
from flexdyn.effects import Effect, effect_from_dict
from flexdyn.effects.extent import MotionExtent

Point = tuple[float, ...]
Unit = tuple[Effect, float]
HALF_GAP_POINTS = 10
"""Number of points of the grid of half gaps."""
NARROWEST_PLAY, WIDEST_PLAY, WIDEST_MADE_UP_PLAY = 0.003, 0.8, 3.0
"""Ends of the grid in units of the joint's deflection; the last one if the deflection was computed without a gap [1].
"""
SMALLEST_HALF_GAP = 0.05
"""Half gap that is always tried, in the same unit [1]."""


@dataclass(frozen=True, eq=False)
class Proposal:
    """One effect at one place.

    Attributes:
        place: ``effect``, ``joint``, ``side`` or ``channel``, and further keys of its place.
        build: the effect from a grid point and the linear values; None if they are not allowed.
        grid: points of the nonlinear parameters; one empty point if there are none.
        positive: whether each linear value must not be negative.
        sizes: of each linear value, at which its column is computed; none: the effect at the grid point is used as it
            is.
        axes: names of the parameters of the grid.
        seldom: whether few drives have the law at this place, however many have it elsewhere.
    """

    place: Mapping[str, str]
    build: Callable[[Point, Sequence[float]], Effect | None]
    grid: tuple[Point, ...] = ((),)
    positive: tuple[bool, ...] = ()
    sizes: tuple[float, ...] = ()
    axes: tuple[str, ...] = ()
    seldom: bool = False

    @property
    def joint(self) -> str:
        """The joint that it acts on, directly or by a channel; empty if it does not act on one joint."""
        return self.place.get("joint") or self.place.get("channel", "").partition(".")[2]

    @property
    def fixed(self) -> bool:
        """Whether no parameter is linear."""
        return not self.sizes

    def make(self, point: Point, x: ArrayLike) -> Effect | None:
        """The effect at a grid point with its linear values; None if they are not allowed."""
        return self.build(point, [] if self.fixed else np.asarray(x, dtype=float).tolist())

    @kept
    def units(self, point: Point) -> list[Unit]:
        """Effects at a grid point, one for each linear value, each with the size of that value in it."""
        alone = [
            (self.build(point, row), size) for row, size in zip(np.diag(self.sizes).tolist(), self.sizes, strict=True)
        ]
        found = alone if self.sizes else [(self.build(point, []), 1.0)]
        return [(effect, size) for effect, size in found if effect is not None]

    def is_of(self, effect: Effect) -> bool:
        """Whether an effect is of this kind at this place."""
        return all(getattr(effect, "name" if key == "effect" else key, None) == it for key, it in self.place.items())


def extent_of(equations: Equations, j: int) -> MotionExtent:
    """What one joint does in all recordings."""
    omega, theta, delta, tau, q = (
        np.concatenate([getattr(m, name)[:, j] for m in equations.motions])
        for name in ("omega", "theta", "delta", "tau", "q")
    )
    of_motion = _of_rigid_motion if equations.computed[j] else Equations.needed
    needed = np.concatenate([of_motion(equations, along, j) for along in equations.motions])
    asked = max(float(np.abs(tau).max()), 1e-9)
    elastic = bool(equations.true.elastic[j])
    wound = float(np.percentile(np.abs(delta - np.median(delta)), 99.5)) if elastic else 0.0
    if equations.replayed[j]:  # a model that lacks what loads the spring does not wind it
        wound = max(wound, float(np.percentile(np.abs(tau), 99.5) / equations.true.stiffness[j]))
    deflection = max(wound, 1e-9)
    return MotionExtent(
        speed=max(float(np.percentile(np.abs(omega), 99.0)), 1e-9),
        span=max(float(np.ptp(theta)), 1e-9),
        deflection=deflection,
        torque=asked,
        given=max(min(float(np.percentile(np.abs(needed), 99.5)), asked), 1e-6 * asked),
        seconds=max(float(m.t[-1] - m.t[0]) for m in equations.motions),
        low=float(q.min()),
        high=float(q.max()),
        ratio=abs(float(equations.true.joints[equations.true.joint_names[j]].gear_ratio)),
        turns=equations.true.robot.kinds[j] != "prismatic",
        half_gaps=tuple(half_gaps(equations, j, deflection)) if elastic else (),
    )


def _of_rigid_motion(equations: Equations, along: SmoothedMotion, j: int) -> Array:
    """Motor torque (times,) that the measured motion needs if no spring winds.

    A position that is computed from the recorded torque needs just this torque, however much of it was lost.
    """
    true, first = equations.true, equations.data[0]
    pairs = ((along.q, along.theta), (along.v, along.omega), (along.a, along.alpha))
    x, u, a = (np.where(first.has_q, *pair) for pair in pairs)
    rubbing = sum(friction_of(true, j, side, x[:, j], u[:, j], along.t) for side in ("motor", "link"))
    total = equations.links.inverse_dynamics(x, u, a)[:, j] + true.rotor_inertia[j] * a[:, j] + rubbing
    return equations.filters.rows(total)


def declared(
    kind: type[Effect], place: Mapping[str, str], extent: MotionExtent, beside: Collection[str] = ()
) -> Proposal:
    """An effect with the linear parameters and the grid that its class declares.

    Its linear parameters may not be negative if their bound says so. They may also not be negative if the model lacks
    the plainer law that a negative parameter would need.

    Args:
        kind: its class.
        place: ``joint`` and ``side``, ``channel`` or ``frame``.
        extent: scales of the joint, for the grid.
        beside: effects of the model at this place.
    """
    lower = {entry.name: entry.metadata["lower"] for entry in kind.parameters()}
    alone = bool(kind.plainer) and not set(kind.plainer) & set(beside)
    positive = [bound >= 0.0 for bound in kind.linear_bounds] or [lower[name] >= 0.0 or alone for name in kind.linear]
    grid = tuple(tuple(float(value) for value in point) for point in kind.tried(extent))
    place = {"effect": kind.name, **place}

    def build(point: Point, x: Sequence[float]) -> Effect | None:
        """The law with these numbers; None: they make none."""
        numbers = kind.numbers_of(point, x)
        return None if numbers is None else effect_from_dict({**place, **numbers})

    return Proposal(place, build, grid, tuple(positive), (kind.small(extent),) * len(positive), kind.axes)


def half_gaps(equations: Equations, j: int, deflection: float) -> list[float]:
    """Half gaps to be tried at a joint [rad or m].

    A gap that is never left would be the same as a missing spring.

    Args:
        equations: of the model.
        j: the joint.
        deflection: nearly the largest one [rad or m].
    """
    if equations.computed[j] or equations.replayed[j]:
        return [float(gap) for gap in deflection * np.geomspace(NARROWEST_PLAY, WIDEST_MADE_UP_PLAY, HALF_GAP_POINTS)]
    widest = max(_unwound(equations, j), SMALLEST_HALF_GAP * deflection)
    grid = deflection * np.geomspace(NARROWEST_PLAY, WIDEST_PLAY, HALF_GAP_POINTS)
    return [*(float(gap) for gap in grid if gap < widest), widest]


def _unwound(equations: Equations, j: int) -> float:
    """Median of ``theta - q - tau_s/K`` along tau_s, where it is large, by the link's equation [rad or m]."""
    true = equations.true
    left = []
    for along in equations.motions:
        terms = joint_terms(true, true.all_effects, along, j)
        carried = terms.tau_s - (terms.link - along.inverse_dynamics[:, j])
        size = np.abs(carried)
        loaded = size >= np.median(size)
        left.append((np.sign(carried) * along.delta[:, j] - size / true.stiffness[j])[loaded])
    return float(np.median(np.concatenate(left)))
