"""Curves of friction over speed, fitted to points of one direction."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from types import MappingProxyType

import numpy as np

from flexdyn.analysis.steady_points import SteadyPoint
from flexdyn.arrays import Array, Flags
from flexdyn.effects.catalogue import find_effect

LAWS: Mapping[str, tuple[str, ...]] = MappingProxyType(
    {"stribeck_friction": ("excess", "velocity"), "quadratic_drag": ("coefficient",)}
)
"""Laws that are tried in addition to Coulomb and viscous friction, and their parameters."""
SLOWEST_STRIBECK_SHARE = 0.5
"""No Stribeck velocity below this share of the slowest speed is tried: the data would hardly show it [1]."""
FASTEST_STRIBECK_SHARE = 0.5
"""No Stribeck velocity above this share of the highest speed is believed: the data show no more than a curve [1]."""
VELOCITY = "stribeck_friction.velocity"
EXCESS = "stribeck_friction.excess"
ALWAYS = MappingProxyType({"level": "coulomb_friction.level", "viscous": "viscous_friction.coefficient"})
"""Parameters of every curve, and those of the effects that they are."""
LIKELY = 3.84
"""Rise of the sum of squared normalised residuals at the ends of an interval of 95 % [1]: a likelihood ratio, the
quantile of chi^2 with one degree of freedom."""


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
        names: names of its parameters.
        values: their values.
        covariance: their covariance, for small errors.
        chi2: sum of squared normalised residuals.
        near: curves with other Stribeck velocities that fit nearly as well.
    """

    names: tuple[str, ...]
    values: Array
    covariance: Array
    chi2: float
    near: tuple[FrictionCurve, ...] = ()

    @classmethod
    def fitted(cls, points: DirectionPoints, laws: Sequence[str], fastest: float = 1.0) -> FrictionCurve:
        """Least squares with the Stribeck velocity on a grid, up to this share of the highest speed."""
        names = ["level", "viscous", *(f"{law}.{name}" for law in laws for name in LAWS[law])]
        if "stribeck_friction" not in laws:
            return cls._at(points, names, None)
        grid = np.geomspace(SLOWEST_STRIBECK_SHARE * points.u.min(), fastest * points.u.max(), 60)
        curves = [cls._at(points, names, float(each)) for each in grid]
        best = min(curves, key=lambda curve: curve.chi2)
        return replace(best, near=tuple(curve for curve in curves if curve.chi2 - best.chi2 < LIKELY))

    @classmethod
    def _at(cls, points: DirectionPoints, names: Sequence[str], velocity: float | None) -> FrictionCurve:
        """The curve that fits best where the Stribeck velocity is given; None: it has no such law."""
        u, tau, std = points.u, points.tau, points.std
        X = np.stack([_column(name, u, velocity) for name in names], axis=1) / std[:, None]
        linear = [k for k, name in enumerate(names) if name != VELOCITY]
        values = np.zeros(len(names))
        values[linear] = _physical(X[:, linear], tau / std)
        left = tau / std - X[:, linear] @ values[linear]
        if velocity is not None:
            at = names.index(VELOCITY)
            values[at] = velocity
            X[:, at] *= values[names.index(EXCESS)]
        length = np.linalg.norm(X, axis=0)
        length[length == 0.0] = 1.0
        inverse = np.linalg.pinv((X / length).T @ (X / length), hermitian=True) / np.outer(length, length)
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
        for curve in self.near or (self,):
            k, C = self.names.index(name), curve.covariance
            variance = C[k, k]
            if self.near:
                at = self.names.index(VELOCITY)
                variance = C[k, k] - C[k, at] ** 2 / C[at, at] if name != VELOCITY and C[at, at] > 0.0 else 0.0
            half = math.sqrt(max(0.0, variance * (LIKELY - curve.chi2 + self.chi2)))
            ends += [float(curve.values[k] - half), float(curve.values[k] + half)]
        return min(ends), max(ends)

    def at(self, u: Array) -> Array:
        """The curve (speeds,)."""
        known = dict(zip(self.names, self.values.tolist(), strict=True))
        velocity = known.pop(VELOCITY, None)
        return np.asarray(sum(value * _column(name, u, velocity) for name, value in known.items()))


def _column(name: str, u: Array, velocity: float | None) -> Array:
    """Derivative of the curve by a parameter; the one by the velocity is for an excess of 1."""
    if velocity is not None and name == VELOCITY:
        return u / velocity**2 * _column(EXCESS, u, velocity)
    law, parameter = ALWAYS.get(name, name).split(".")
    numbers = {parameter: 1.0} | ({"velocity": velocity} if name == EXCESS else {})
    return find_effect(law).from_dict({"joint": "joint", "side": "motor", **numbers}).torque(0.0, u)


def _physical(X: Array, y: Array) -> Array:
    """Least squares in which only the first parameter, the level, may be negative: friction never supplies power."""
    from scipy.optimize import nnls

    both = nnls(np.column_stack([X, -X[:, 0]]), y)[0]  # the level is the difference of two numbers
    return np.asarray([both[0] - both[-1], *both[1:-1]])
