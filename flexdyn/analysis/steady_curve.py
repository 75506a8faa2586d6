"""Curves of friction over speed, fitted to points of one direction."""

from __future__ import annotations

import itertools
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from flexdyn.analysis.steady_points import SteadyPoint
from flexdyn.arrays import Array, Flags
from flexdyn.effects import registered
from flexdyn.effects.catalogue import find_effect

SLOWEST_SHARE = 0.5
"""No speed of a law is tried below this share of the slowest recorded speed: the data would hardly show it [1]."""
FASTEST_SHARE = 0.5
"""No speed of a law is believed above this share of the highest recorded one: data show no more than a curve [1]."""
SPEEDS_TRIED = 60
"""Values that are tried of a law's speed."""
SPEED_SLOPE_STEP = 1e-5
"""Relative step of the slope by a law's speed [1]: rounding and curvature then are about 1e-10 of the slope."""
LIKELY = 3.84
"""Rise of the sum of squared normalised residuals at the ends of an interval of 95 % [1]: a likelihood ratio, the
quantile of chi^2 with one degree of freedom."""


def _always(regressed: str) -> str:
    """Law and parameter of which every curve has one: the law that declares this place in a linear regressor."""
    kind = next(each for each in registered().values() if each.regressed == regressed)
    return f"{kind.name}.{kind.linear[0]}"


LEVEL, VISCOUS = _always("coulomb"), _always("viscous")
"""Law and parameter of the part that does not depend on the speed, and of the part in proportion to it."""


def tried_laws() -> tuple[str, ...]:
    """Laws that are tried in addition to Coulomb and viscous friction: those that declare it by `steady`."""
    return tuple(kind.name for kind in registered().values() if kind.steady)


def numbers_of_law(law: str) -> tuple[str, ...]:
    """Names of the parameters of a law that a fit estimates: what it is linear in, then its speeds."""
    kind = find_effect(law)
    return (*kind.linear, *kind.moved_axes())


@dataclass(frozen=True, eq=False)
class DirectionPoints:
    """Points of one direction: speeds, torques along the motion and standard deviations."""

    u: Array
    tau: Array
    std: Array

    @classmethod
    def of(cls, points: Sequence[SteadyPoint], direction: int) -> DirectionPoints:
        """The points of a direction, by speed."""
        own = sorted((p for p in points if p.speed * direction > 0.0), key=lambda p: abs(p.speed))
        u, tau, std = (np.array([getattr(p, key) for p in own]) for key in ("speed", "torque", "std"))
        return cls(np.abs(u), direction * tau, std)

    def scaled(self, factor: float) -> DirectionPoints:
        """The points with larger standard deviations."""
        return DirectionPoints(self.u, self.tau, factor * self.std)

    def part(self, rows: Flags) -> DirectionPoints:
        """A selection of the points."""
        return DirectionPoints(self.u[rows], self.tau[rows], self.std[rows])

    def off(self, curve: FrictionCurve) -> float:
        """Sum of squared normalised residuals of a curve."""
        return float((((curve.at(self.u) - self.tau) / self.std) ** 2).sum()) if len(self.u) else 0.0


@dataclass(frozen=True, eq=False)
class FrictionCurve:
    """A fitted curve.

    Attributes:
        names: law and name of its parameters.
        values: their values.
        covariance: their covariance, for small errors.
        chi2: sum of squared normalised residuals.
        near: curves with other speeds of the laws that fit nearly as well.
    """

    names: tuple[str, ...]
    values: Array
    covariance: Array
    chi2: float
    near: tuple[FrictionCurve, ...] = ()

    @classmethod
    def fitted(cls, points: DirectionPoints, laws: Sequence[str], fastest: float = 1.0) -> FrictionCurve:
        """Least squares with the laws' speeds on a grid, up to this share of the highest recorded speed."""
        names = [LEVEL, VISCOUS, *(f"{law}.{name}" for law in laws for name in numbers_of_law(law))]
        speeds = [name for name in names if _is_speed(name)]
        if not speeds:
            return cls._at(points, names, {})
        grid = np.geomspace(SLOWEST_SHARE * points.u.min(), fastest * points.u.max(), SPEEDS_TRIED).tolist()
        tried = itertools.product(grid, repeat=len(speeds))
        curves = [cls._at(points, names, dict(zip(speeds, each, strict=True))) for each in tried]
        best = min(curves, key=lambda curve: curve.chi2)
        return replace(best, near=tuple(curve for curve in curves if curve.chi2 - best.chi2 < LIKELY))

    @classmethod
    def _at(cls, points: DirectionPoints, names: Sequence[str], speeds: Mapping[str, float]) -> FrictionCurve:
        """The curve that fits best where the speeds of its laws are given."""
        u, tau, std = points.u, points.tau, points.std
        linear = [name for name in names if name not in speeds]
        X = np.stack([_column(name, u, speeds) for name in linear], axis=1) / std[:, None]
        numbers = dict(zip(linear, _physical(X, tau / std).tolist(), strict=True)) | dict(speeds)
        left = tau / std - X @ np.array([numbers[name] for name in linear])
        by_name = dict(zip(linear, X.T, strict=True)) | {name: _slope(name, u, numbers) / std for name in speeds}
        slopes = np.stack([by_name[name] for name in names], axis=1)
        length = np.linalg.norm(slopes, axis=0)
        length[length == 0.0] = 1.0
        inverse = np.linalg.pinv((slopes / length).T @ (slopes / length), hermitian=True) / np.outer(length, length)
        values = np.array([numbers[name] for name in names])
        return cls(tuple(names), values, np.asarray(inverse), float(left @ left))

    @property
    def size(self) -> int:
        """Number of parameters."""
        return len(self.names)

    def bic(self, points: int) -> float:
        """Bayesian information criterion of a fit to so many points."""
        return self.chi2 + self.size * math.log(points)

    def number(self, name: str) -> tuple[float, float]:
        """Value and standard deviation."""
        k = self.names.index(name)
        return float(self.values[k]), float(np.sqrt(self.covariance[k, k]))

    def interval(self, name: str) -> tuple[float, float]:
        """Interval of 95 % by the profile likelihood: the parameters of a broad rise are far from Gaussian."""
        ends = []
        k, fixed = self.names.index(name), [k for k, each in enumerate(self.names) if _is_speed(each)]
        for curve in self.near or (self,):
            variance = curve._variance(k, fixed)
            half = math.sqrt(max(0.0, variance * (LIKELY - curve.chi2 + self.chi2)))
            ends += [float(curve.values[k] - half), float(curve.values[k] + half)]
        return min(ends), max(ends)

    def _variance(self, k: int, fixed: Sequence[int]) -> float:
        """Variance of a parameter where those of other places are fixed; 0 where the curve does not depend on one."""
        C = self.covariance
        if k in fixed or not all(C[at, at] > 0.0 for at in fixed):
            return 0.0
        return float(C[k, k] - C[k, fixed] @ np.linalg.pinv(C[np.ix_(fixed, fixed)], hermitian=True) @ C[fixed, k])

    def at(self, u: Array) -> Array:
        """The curve (speeds,)."""
        known = dict(zip(self.names, self.values.tolist(), strict=True))
        return np.asarray(sum(value * _column(name, u, known) for name, value in known.items() if not _is_speed(name)))


def _is_speed(name: str) -> bool:
    """Whether a law is not linear in a parameter: it is a speed, of which a grid is tried."""
    law, parameter = name.split(".")
    return parameter in find_effect(law).moved_axes()


def _column(name: str, u: Array, speeds: Mapping[str, float]) -> Array:
    """Derivative of the curve by a parameter that it is linear in."""
    law, parameter = name.split(".")
    kind = find_effect(law)
    alone = {each: float(each == parameter) for each in kind.linear}
    return _torque(law, u, alone | {each: speeds[f"{law}.{each}"] for each in kind.moved_axes()})


def _slope(name: str, u: Array, numbers: Mapping[str, float]) -> Array:
    """Derivative of the curve by a speed of one of its laws."""
    law, parameter = name.split(".")
    own = {each: numbers[f"{law}.{each}"] for each in numbers_of_law(law)}
    step = SPEED_SLOPE_STEP * own[parameter]
    above, below = (_torque(law, u, own | {parameter: own[parameter] + h}) for h in (step, -step))
    return (above - below) / (2.0 * step)


def _torque(law: str, u: Array, numbers: Mapping[str, float]) -> Array:
    """The torque against a motion at these speeds."""
    return find_effect(law).from_dict({"joint": "joint", "side": "motor", **numbers}).torque(0.0, u)


def _physical(X: Array, y: Array) -> Array:
    """Least squares in which only the first parameter, the level, may be negative: friction never supplies power."""
    from scipy.optimize import nnls

    both = nnls(np.column_stack([X, -X[:, 0]]), y)[0]  # the level is the difference of two numbers
    return np.asarray([both[0] - both[-1], *both[1:-1]])
