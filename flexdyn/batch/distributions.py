"""Distributions: how a number varies from run to run, by random draws or over a grid."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from statistics import NormalDist
from typing import Any, Self

import numpy as np

from flexdyn.arrays import Array
from flexdyn.checks import check_known, number
from flexdyn.errors import InputError

_STANDARD_NORMAL = NormalDist()
MAX_GRID = 1_000_000


@dataclass(frozen=True)
class DistributionLaw:
    """A kind of distribution with two parameters.

    Attributes:
        numbers: names of the parameters.
        quantile: function of both and a share (0 < share < 1).
        problem: function of both that says why they are not allowed; empty if they are.
        bounded: whether the parameters are the bounds of the draws.
    """

    numbers: tuple[str, str]
    quantile: Callable[[float, float, float], float]
    problem: Callable[[float, float], str]
    bounded: bool = False


def _log_problem(median: float, std: float) -> str:
    if not median > 0:
        return "the median must be above 0"
    return "" if std > 0 else "the standard deviation of the logarithm must be above 0"


LAWS: Mapping[str, DistributionLaw] = {
    "uniform": DistributionLaw(
        ("lowest", "highest"),
        lambda lowest, highest, share: lowest + share * (highest - lowest),
        lambda lowest, highest: "" if lowest < highest else "the first number must be the lower one",
        bounded=True,
    ),
    "normal": DistributionLaw(
        ("mean", "standard deviation"),
        lambda mean, std, share: mean + std * _STANDARD_NORMAL.inv_cdf(share),
        lambda mean, std: "" if std > 0 else "the standard deviation must be above 0",
    ),
    "lognormal": DistributionLaw(
        ("median", "standard deviation of the logarithm"),
        lambda median, std, share: median * math.exp(std * _STANDARD_NORMAL.inv_cdf(share)),
        _log_problem,
    ),
}
"""Kinds of distributions by their names in a study file; all lognormal draws have the sign of the median."""


@dataclass(frozen=True)
class Distribution:
    """A distribution with two parameters, drawn by the inverse of its cumulative distribution.

    Args:
        name: of its law.
        first: parameter.
        second: parameter.

    Raises:
        InputError: parameters that are not allowed.
    """

    name: str
    first: float
    second: float

    def __post_init__(self) -> None:
        """Check the parameters."""
        for given in (self.first, self.second):
            number(self.name, given, remedy=_written(self.name))
        problem = self.law.problem(self.first, self.second)
        if problem:
            raise InputError(problem, key=self.name, value=[self.first, self.second], remedy=_written(self.name))

    @property
    def law(self) -> DistributionLaw:
        """Its kind."""
        return LAWS[self.name]

    def value(self, share: float) -> float:
        """The quantile for a share (0 < share < 1)."""
        return self.law.quantile(self.first, self.second, share)

    def values(self, shares: Array) -> Array:
        """The quantiles for several shares."""
        return np.array([self.value(share) for share in shares.tolist()])

    @property
    def centre(self) -> float:
        """The median."""
        return self.value(0.5)

    @property
    def usual(self) -> float:
        """A typical number, but not the median, which is often zero."""
        return self.value(0.6)

    @property
    def extremes(self) -> tuple[float, ...]:
        """Bounds of the draws, if there are any."""
        return (float(self.first), float(self.second)) if self.law.bounded else ()


@dataclass(frozen=True)
class Grid:
    """Every value of a list, combined with every value of every other grid.

    Args:
        values: in their order.

    Raises:
        InputError: not finite numbers, or one of them twice.
    """

    values: tuple[float, ...]

    @classmethod
    def of(cls, entry: Any) -> Self:
        """Make it from a study file's list.

        Raises:
            InputError: it is no list of different finite numbers.
        """
        if not isinstance(entry, list | tuple) or not entry:
            raise InputError("a list of numbers is needed", key="grid", value=entry, remedy="write {grid: [1, 2, 3]}")
        if len(entry) > MAX_GRID:
            raise InputError(f"more than {MAX_GRID} values", key="grid", value=len(entry))
        seen: dict[float, None] = {}
        for i, value in enumerate(entry):
            found = number(f"grid[{i}]", value)
            if found in seen:
                raise InputError("the value is in the grid twice", key=f"grid[{i}]", value=value)
            seen[found] = None
        return cls(tuple(seen))

    @property
    def centre(self) -> float:
        """The value in the middle of the list."""
        return self.values[len(self.values) // 2]

    @property
    def usual(self) -> float:
        """The value that is farthest from zero."""
        return max(self.values, key=abs)

    @property
    def extremes(self) -> tuple[float, ...]:
        """The least and the greatest value."""
        return (min(self.values), max(self.values))


DISTRIBUTIONS = (*LAWS, "grid")
"""Words of a study file."""


def distribution(entry: Any) -> Distribution | Grid:
    """Make a distribution from a study file's ``{uniform: [2000, 6000]}``.

    Raises:
        InputError: no such distribution, or numbers that are not allowed.
    """
    if not isinstance(entry, Mapping) or len(entry) != 1:
        known = ", ".join(f"{{{name}: [...]}}" for name in DISTRIBUTIONS)
        raise InputError("one distribution is needed", value=entry, remedy=f"write one of {known}")
    ((name, numbers),) = entry.items()
    check_known(name, DISTRIBUTIONS, "no such distribution", key=str(name))
    if name == "grid":
        return Grid.of(numbers)
    if not isinstance(numbers, list | tuple) or len(numbers) != 2:
        raise InputError("two numbers are needed", key=name, value=numbers, remedy=_written(name))
    return Distribution(name, *numbers)


def _written(name: str) -> str:
    return f"write {{{name}: [{', '.join(LAWS[name].numbers)}]}}"
