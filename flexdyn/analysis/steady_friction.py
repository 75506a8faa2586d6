"""steady_friction: friction laws from runs at constant speed, for each direction, checked at other speeds."""

from __future__ import annotations

import itertools
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from flexdyn.analysis.steady_curve import (
    FASTEST_SHARE,
    LEVEL,
    SLOWEST_SHARE,
    VISCOUS,
    DirectionPoints,
    FrictionCurve,
    numbers_of_law,
    tried_laws,
)
from flexdyn.analysis.steady_points import SteadyPoint
from flexdyn.arrays import Array
from flexdyn.effects import effect_from_dict
from flexdyn.effects.catalogue import find_effect
from flexdyn.errors import InputError
from flexdyn.io.locked import Locked

LEAST_SPEEDS = 8
"""Speeds of one direction that are needed: four to fit and four to check."""
DECISIVE_DROP = 10.0
"""A law is named if BIC, and the squared prediction errors at other speeds, decrease by at least this."""
SURE = 3.0
"""Standard deviations by which its coefficient must be above zero: root of the decrease of chi^2."""
PREDICTION_RISE = 4.0
"""If the squared errors at points that were not fitted increase by more than this, they contradict a law."""


@dataclass(frozen=True)
class LawTrial(Locked):
    """One law beside all others that were named.

    Attributes:
        effect: its name.
        named: whether it passed all tests.
        numbers: value and standard deviation by name, for small errors.
        intervals: of 95 % by the profile likelihood, which is valid for large errors too.
        delta_bic: BIC of the best curve without the law, whatever other laws it has, less that of the curve with it.
        prediction: decrease of the squared normalised errors at speeds that were not fitted: half of the speeds is
            fitted and the other half predicted, and the other way round.
        check: the same at points that are only used for checking; 0 if there are none.
        why: why the law is not named; empty if it is.

    Example:
        >>> points = [fd.SteadyPoint(u, 1.0 + 0.5 * u, 0.01) for u in np.linspace(0.2, 2.0, 10)]
        >>> [trial.effect for trial in fd.steady_friction(points)[1].trials]  # beside Coulomb and viscous friction
        ['stribeck_friction', 'quadratic_drag']
    """

    effect: str
    named: bool
    numbers: Mapping[str, tuple[float, float]]
    intervals: Mapping[str, tuple[float, float]]
    delta_bic: float
    prediction: tuple[float, float]
    check: float
    why: str


@dataclass(frozen=True)
class SteadyFriction:
    """Friction in one direction.

    Attributes:
        direction: +1 or -1.
        level: the part of the torque that does not depend on the speed, and its standard deviation: Coulomb friction
            plus load or gravity, which one direction alone cannot separate [N m or N].
        viscous: coefficient and standard deviation [N m s/rad or N s/m].
        trials: of every law that declares `steady`.
        scatter: of the points about the curve, in units of their own standard deviations [1].
        speeds: number of speeds.

    Example:
        >>> points = [fd.SteadyPoint(u, 1.0 + 0.5 * u, 0.01) for u in np.linspace(0.2, 2.0, 10)]
        >>> found = fd.steady_friction(points)[1]  # positive direction
        >>> found.named, round(found.torque(1.0), 3)
        ((), 1.5)
    """

    direction: int
    level: tuple[float, float]
    viscous: tuple[float, float]
    trials: tuple[LawTrial, ...]
    scatter: float
    speeds: int

    @property
    def named(self) -> tuple[str, ...]:
        """Laws that the runs show in addition to Coulomb and viscous friction."""
        return tuple(each.effect for each in self.trials if each.named)

    def torque(self, speed: float) -> float:
        """Torque of the curve at a speed of this direction [N m or N]; it has the sign of the speed."""
        u = abs(speed)
        total = self.level[0] + self.viscous[0] * u
        for each in self.trials:
            if each.named:
                numbers = {name: value for name, (value, _) in each.numbers.items()}
                law = effect_from_dict({"effect": each.effect, "joint": "any", "side": "motor", **numbers})
                total += float(law.torque(0.0, u))
        return self.direction * total


def steady_friction(points: Sequence[SteadyPoint], check: Sequence[SteadyPoint] = ()) -> dict[int, SteadyFriction]:
    """Identify friction from runs at constant speed, for each direction.

    ``abs(tau) = level + viscous u + excess exp(-u/velocity) + coefficient u^2`` over u = abs(speed). Points are
    weighted by their standard deviations, which are enlarged by the scatter about the curve with all laws. A law in
    addition to level and viscous friction is named if BIC is enough below that of every curve without it, if its
    coefficient is significantly above zero, if each half of the speeds predicts the other half better with it, and if
    runs that were not fitted do not contradict it.

    Args:
        points: of runs at constant speed; see `steady_points`.
        check: other points, from another day or another motion, at any speeds.

    Returns:
        The friction by direction, +1 and -1, for directions with 8 speeds or more.

    Raises:
        InputError: no direction has enough speeds.

    Example:
        >>> points = [fd.SteadyPoint(u, 1.0 + 0.5 * u, 0.01) for u in np.linspace(0.2, 2.0, 10)]
        >>> found = fd.steady_friction(points)[1]  # positive direction
        >>> round(found.level[0], 3), round(found.viscous[0], 3)
        (1.0, 0.5)
    """
    found = {}
    for direction in (1, -1):
        own = DirectionPoints.of(points, direction)
        if len(own.u) >= LEAST_SPEEDS:
            found[direction] = _of_direction(direction, own, DirectionPoints.of(check, direction))
    if not found:
        remedy = f"record {LEAST_SPEEDS} constant speeds or more, from creeping to fast"
        raise InputError("too few speeds in either direction", key="points", value=len(points), remedy=remedy)
    return found


def _of_direction(direction: int, points: DirectionPoints, check: DirectionPoints) -> SteadyFriction:
    """Friction in one direction: which laws are named, and the numbers of those that are."""
    tried = tried_laws()
    sets = [laws for count in range(len(tried) + 1) for laws in itertools.combinations(tried, count)]
    whole = FrictionCurve.fitted(points, tried)
    scatter = math.sqrt(whole.chi2 / max(1, len(points.u) - whole.size))
    points, check = (each.scaled(max(1.0, scatter)) for each in (points, check))
    believed = {laws: FrictionCurve.fitted(points, laws, FASTEST_SHARE) for laws in sets}
    bic = {laws: curve.bic(len(points.u)) for laws, curve in believed.items()}
    named = min(bic, key=lambda laws: bic[laws])
    while True:  # a law that is not named no longer stands beside the others, but stays their rival
        trials = tuple(_trial(law, points, check, tuple(each for each in named if each != law), bic) for law in tried)
        refused = [each.effect for each in trials if each.effect in named and not each.named]
        if not refused:
            break
        named = tuple(law for law in named if law not in refused)
    now = FrictionCurve.fitted(points, [each.effect for each in trials if each.named])
    return SteadyFriction(direction, now.number(LEVEL), now.number(VISCOUS), trials, scatter, len(points.u))


def _trial(
    law: str,
    points: DirectionPoints,
    check: DirectionPoints,
    others: tuple[str, ...],
    bic: Mapping[tuple[str, ...], float],
) -> LawTrial:
    """Whether one law is named beside others, and if not, why."""
    laws = tuple(each for each in tried_laws() if each in (*others, law))
    without, curve = FrictionCurve.fitted(points, others), FrictionCurve.fitted(points, laws)
    rival = min((each for each in bic if law not in each), key=lambda each: bic[each])
    drop = bic[rival] - curve.bic(len(points.u))
    odd = np.arange(len(points.u)) % 2 == 1
    one, two = (_predicted(points.part(half), points.part(~half), others, laws) for half in (~odd, odd))
    checked = check.off(without) - check.off(curve)
    numbers = {name: curve.number(f"{law}.{name}") for name in numbers_of_law(law)}
    why = ""
    if without.chi2 - curve.chi2 < SURE**2:
        why = "its coefficient is not significantly above zero"
    elif drop < DECISIVE_DROP and set(rival) <= set(others):
        why = "it improves the fit too little"
    elif drop < DECISIVE_DROP:
        why = f"{' and '.join(each for each in rival if each not in others)} explains the runs as well or better"
    elif min(one, two) < 0.0 or one + two < DECISIVE_DROP:
        why = "other speeds do not confirm it"
    elif outside := [name for name in find_effect(law).moved_axes() if not _within(numbers[name][0], points.u)]:
        why = f"its {outside[0]} is outside the recorded speeds"
    elif checked < -PREDICTION_RISE:
        why = "runs that were not used in the fit contradict it"
    intervals = {name: curve.interval(f"{law}.{name}") for name in numbers_of_law(law)}
    return LawTrial(law, not why, numbers, intervals, drop, (one, two), checked, why)


def _predicted(fit: DirectionPoints, rest: DirectionPoints, *laws: tuple[str, ...]) -> float:
    """Decrease of the squared errors at the other points from the first laws to the second."""
    before, after = (rest.off(FrictionCurve.fitted(fit, each)) for each in laws)
    return before - after


def _within(speed: float, u: Array) -> bool:
    return bool(1.01 * SLOWEST_SHARE * u.min() < speed < FASTEST_SHARE * u.max())
