"""The fitted numbers over the tensions: how sure each is, which moved and which stayed."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from damper_data import FIT, Array, needed_force
from damper_fit import model_of, numbers_of, point_of

import flexdyn as fd

STEP = 1e-3
"""Of the logarithm of a number, for a slope [1]."""
CYCLE = 1.0
"""Length of a cycle of the 1 Hz files [s]."""
STAYED = 1.25
"""A number stayed where its largest value is at most so many times its smallest [1]."""


@dataclass(frozen=True)
class Compared:
    """A number over the tensions.

    Attributes:
        name: of the number.
        values: by file.
        stds: their standard errors, by file.
    """

    name: str
    values: Mapping[str, float]
    stds: Mapping[str, float]

    @property
    def ratio(self) -> float:
        """Largest over smallest [1]."""
        sizes = [abs(each) for each in self.values.values()]
        return max(sizes) / min(sizes)

    @property
    def moved(self) -> bool:
        """Whether it is another one at another tension.

        By its size: three cycles are so alike that any two fits differ by more than the standard errors.
        """
        return self.ratio > STAYED


def with_sums(numbers: Mapping[str, float]) -> dict[str, float]:
    """The numbers with the force of sliding in either direction, which is better known than its parts [N]."""
    bristle, offset = numbers["presliding_level"], numbers["offset"]
    sums = {
        "sliding_positive": numbers["level_positive"] + bristle + offset,
        "sliding_negative": numbers["level_negative"] + bristle - offset,
    }
    return dict(numbers) | sums


def spread(record: fd.Recording, numbers: Mapping[str, float]) -> dict[str, float]:
    """Standard errors of the numbers and of their sums, by leaving out one fitted cycle after the other.

    Each time the fit takes one Gauss-Newton step from the numbers of all cycles (jackknife over cycles). What is left
    is no noise but comes again in every cycle, so these say how well the cycles agree, and not how right the law is.
    """
    seen = record.trim(0.0, FIT[1])
    x = point_of(dict(numbers))
    rows = seen.t >= FIT[0]
    cycle = np.floor((seen.t[rows] - FIT[0]) / CYCLE)

    def force(at: Array) -> Array:
        return needed_force(*model_of(at), seen.t, seen["q.damper"])[rows]

    left = seen["tau.damper"][rows] - force(x)
    slopes = np.stack([(force(x + s) - force(x - s)) / (2.0 * STEP) for s in STEP * np.eye(len(x))], axis=1)
    drawn = []
    for k in np.unique(cycle):
        kept = cycle != k
        step = np.linalg.lstsq(slopes[kept], left[kept], rcond=1e-3)[0]
        drawn.append(with_sums(numbers_of(x + np.clip(step, -1.0, 1.0))))
    n = len(drawn)
    return {
        name: float(np.sqrt((n - 1) / n * ((found - found.mean()) ** 2).sum()))
        for name in drawn[0]
        if (found := np.array([each[name] for each in drawn])).size
    }


def compared(fits: Mapping[str, Mapping[str, float]], records: Mapping[str, fd.Recording]) -> list[Compared]:
    """All numbers over the files of the fits."""
    stds = {file: spread(records[file], numbers) for file, numbers in fits.items()}
    all_numbers = {file: with_sums(numbers) for file, numbers in fits.items()}
    names = next(iter(all_numbers.values()))
    return [
        Compared(
            name,
            {file: numbers[name] for file, numbers in all_numbers.items()},
            {file: each[name] for file, each in stds.items()},
        )
        for name in names
    ]
