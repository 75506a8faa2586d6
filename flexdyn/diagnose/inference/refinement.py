"""Grid points between the grid's: the nonlinear parameters of a structure's effects at their most likely values."""

from __future__ import annotations

import numpy as np

from flexdyn.diagnose.inference.space import Space, Structure

POINTS_TRIED = 14
"""Points that are tried for each nonlinear parameter, at most."""
SWEEPS = 4
"""Times that all parameters are moved in turn, at most: they depend on one another."""
NEGLIGIBLE_GAIN = 0.05
"""Change of the log posterior that is none."""


def refined(space: Space, structure: Structure) -> Structure:
    """The structure with every nonlinear parameter moved to where its log posterior is greatest, one after another."""
    here = structure
    for _ in range(SWEEPS):
        before, axes = space.value(here), 0
        for c, _ in sorted(structure):
            candidate = space.candidates[c]
            if candidate.choices > 1 and candidate.proposal is not None:
                moved = candidate.moved_axes if candidate.points[0] else ()  # what stands has no grid
                axes += len(moved)
                for axis in moved:
                    here = _best_along(space, here, c, axis)
        if axes < 2 or space.value(here) - before < NEGLIGIBLE_GAIN:
            break
    return here


def _best_along(space: Space, here: Structure, c: int, axis: int) -> Structure:
    """The best point along one parameter: steps between the neighbours that the grid has, halved, and parabolas."""
    line = _Line(space, here, c, axis)
    if line.low == line.high:
        return here
    down, up = 0.5 * (line.centre - line.low), 0.5 * (line.high - line.centre)
    for _ in range(POINTS_TRIED // 2):
        best, before = line.best, line.value(line.best)
        for x in (best - down, best + up):
            line.ask(x)
        if line.best != best:
            if line.value(line.best) - before < NEGLIGIBLE_GAIN:
                break
            continue
        line.ask(_vertex(best, line.values()))
        down, up = 0.5 * down, 0.5 * up
        if min((before - y for x, y in line.values().items() if x != best), default=0.0) < NEGLIGIBLE_GAIN:
            break
    return line.natural()


class _Line:
    """A candidate's points along one parameter, and the structures with them.

    Args:
        space: of the candidates.
        here: structure that holds it.
        c: the candidate.
        axis: the parameter.
    """

    def __init__(self, space: Space, here: Structure, c: int, axis: int) -> None:
        self.space, self.c, self.axis = space, c, axis
        self.candidate = space.candidates[c]
        (now,) = (p for owner, p in here if owner == c)
        self.others = here - {(c, now)}
        self.point = self.candidate.points[now]
        self.centre = self.point[axis]
        grid = [point[axis] for point in self.candidate.points[: self.candidate.choices]]
        low, self.high = _bracket(grid, self.centre)
        self.low = max(low, 1.0) if self.candidate.law.cycles else low
        self.tried = {self.centre: (space.value(here), here)}

    @property
    def best(self) -> float:
        """The most likely value of the parameter so far."""
        return max(self.tried, key=lambda x: self.tried[x][0])

    def value(self, x: float) -> float:
        """Log posterior at one that was tried."""
        return self.tried[x][0]

    def values(self) -> dict[float, float]:
        """Log posterior at all that were tried."""
        return {x: value for x, (value, _) in self.tried.items()}

    def ask(self, x: float | None, *, outside: bool = False) -> None:
        """Try a value, if it lies between the grid's neighbours and is new."""
        if x is None or x in self.tried or not (outside or self.low < x < self.high):
            return
        place = self.space.grow(self.c, (*self.point[: self.axis], float(x), *self.point[self.axis + 1 :]))
        if place is not None:
            structure = self.others | {(self.c, place)}
            self.tried[x] = (self.space.value(structure), structure)

    def natural(self) -> Structure:
        """The structure at the best value, those of harmonics that are natural among them."""
        best = self.best
        for x in self.candidate.natural(best) if self.candidate.law.cycles else ():
            self.ask(x, outside=True)
        return self.tried[self.best][1]


def _bracket(grid: list[float], centre: float) -> tuple[float, float]:
    """The neighbours on the grid; beyond its ends, as far again as the last step."""
    values = np.unique(grid)
    if len(values) < 2:
        return centre, centre
    positive = values[0] > 0.0
    outer_low = values[0] ** 2 / values[1] if positive else 2.0 * values[0] - values[1]
    outer_high = values[-1] ** 2 / values[-2] if positive else 2.0 * values[-1] - values[-2]
    below, above = values[values < centre], values[values > centre]
    return float(below[-1] if len(below) else outer_low), float(above[0] if len(above) else outer_high)


def _vertex(best: float, tried: dict[float, float]) -> float | None:
    """Of the parabola through the best point and its neighbours."""
    below = [x for x in tried if x < best]
    above = [x for x in tried if x > best]
    if not below or not above:
        return None
    a, b = max(below), min(above)
    fa, f0, fb = (tried[x] - tried[best] for x in (a, best, b))
    numerator = (best - a) ** 2 * (f0 - fb) - (best - b) ** 2 * (f0 - fa)
    denominator = (best - a) * (f0 - fb) - (best - b) * (f0 - fa)
    return None if denominator == 0.0 else best - 0.5 * numerator / denominator
