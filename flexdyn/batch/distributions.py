"""Distributions: how a number varies from run to run, by random draws or over a grid."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from statistics import NormalDist
from typing import Any, ClassVar, Self

import numpy as np
from numpy.typing import NDArray

from flexdyn.checks import number
from flexdyn.errors import InputError, check_known

_STANDARD_NORMAL = NormalDist()
MAX_GRID = 1_000_000


@dataclass(frozen=True)
class Distribution:
    """Base: a distribution with two parameters, drawn by the inverse of its cumulative distribution.

    Class attributes:
        name: in a study file.
        numbers: names of its two parameters.
    """

    name: ClassVar[str] = ""
    numbers: ClassVar[tuple[str, str]] = ("", "")

    first: float
    second: float

    def __post_init__(self) -> None:
        """Check the parameters.

        Raises:
            InputError: they are not allowed.
        """
        remedy = f"write {{{self.name}: [{', '.join(self.numbers)}]}}"
        for given in (self.first, self.second):
            number(self.name, given, remedy=remedy)
        problem = self._problem()
        if problem:
            raise InputError(problem, key=self.name, value=[self.first, self.second], remedy=remedy)

    @classmethod
    def of(cls, entry: Any) -> Self:
        """Make it from a study file's two numbers.

        Raises:
            InputError: they are not two, or are not allowed.
        """
        if not isinstance(entry, list | tuple) or len(entry) != 2:
            remedy = f"write {{{cls.name}: [{', '.join(cls.numbers)}]}}"
            raise InputError("two numbers are needed", key=cls.name, value=entry, remedy=remedy)
        return cls(*entry)

    def value(self, share: float) -> float:
        """The quantile for a share (0 < share < 1)."""
        raise NotImplementedError

    def values(self, shares: NDArray[np.float64]) -> NDArray[np.float64]:
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
        return ()

    def _problem(self) -> str:
        return ""


class Uniform(Distribution):
    """All numbers between two bounds with the same density."""

    name = "uniform"
    numbers = ("lowest", "highest")

    def value(self, share: float) -> float:
        """The bound at 0, the other at 1, linear between them."""
        return self.first + share * (self.second - self.first)

    def values(self, shares: NDArray[np.float64]) -> NDArray[np.float64]:
        """The same for many shares."""
        return self.first + shares * (self.second - self.first)

    @property
    def extremes(self) -> tuple[float, ...]:
        """The two bounds."""
        return (float(self.first), float(self.second))

    def _problem(self) -> str:
        return "" if self.first < self.second else "the first number must be the lower one"


class Normal(Distribution):
    """The normal distribution."""

    name = "normal"
    numbers = ("mean", "standard deviation")

    def value(self, share: float) -> float:
        """Mean plus a multiple of the standard deviation."""
        return self.first + self.second * _STANDARD_NORMAL.inv_cdf(share)

    def _problem(self) -> str:
        return "" if self.second > 0 else "the standard deviation must be above 0"


class LogNormal(Distribution):
    """The normal distribution of the logarithm: all draws have the sign of the median."""

    name = "lognormal"
    numbers = ("median", "standard deviation of the logarithm")

    def value(self, share: float) -> float:
        """Median times the exponential of a multiple of the standard deviation."""
        return self.first * math.exp(self.second * _STANDARD_NORMAL.inv_cdf(share))

    def _problem(self) -> str:
        if not self.first > 0:
            return "the median must be above 0"
        return "" if self.second > 0 else "the standard deviation of the logarithm must be above 0"


@dataclass(frozen=True)
class Grid:
    """Every value of a list, combined with every value of every other grid.

    Args:
        values: in their order.

    Raises:
        InputError: not finite numbers, or one of them twice.
    """

    name: ClassVar[str] = "grid"

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
                raise InputError("the value stands twice in the grid", key=f"grid[{i}]", value=value)
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


DISTRIBUTIONS: dict[str, type[Distribution] | type[Grid]] = {
    kind.name: kind for kind in (Uniform, Normal, LogNormal, Grid)
}


def distribution(entry: Any) -> Distribution | Grid:
    """Make a distribution from a study file's ``{uniform: [2000, 6000]}``.

    Raises:
        InputError: no such distribution, or numbers that are not allowed.
    """
    known = ", ".join(f"{{{name}: [...]}}" for name in DISTRIBUTIONS)
    if not isinstance(entry, Mapping) or len(entry) != 1:
        raise InputError("one distribution is needed", value=entry, remedy=f"write one of {known}")
    ((name, numbers),) = entry.items()
    check_known(name, DISTRIBUTIONS, "no such distribution", key=str(name))
    return DISTRIBUTIONS[name].of(numbers)
