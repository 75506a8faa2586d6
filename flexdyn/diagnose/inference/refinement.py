"""Grid points between the grid's: the nonlinear parameters of a structure's effects at their most likely values."""

from __future__ import annotations

import numpy as np

from flexdyn.diagnose.inference.space import Space, Structure

TRIES = 14
"""Points that are tried for each nonlinear parameter, at most."""
SWEEPS = 4
"""Times that all parameters are moved in turn, at most: they depend on one another."""
NATURAL = 5.0
"""Log odds of a harmonic that is a whole number, or a whole number of motor turns, to one that is not."""
SETTLED = 0.05
"""Change of the log posterior that is none."""


def refined(space: Space, structure: Structure) -> Structure:
    """The structure with every nonlinear parameter moved to where its log posterior is greatest, one after another."""
    here = structure
    for _ in range(SWEEPS):
        before, axes = space.value(here), 0
        for c, _ in sorted(structure):
            candidate = space.candidates[c]
            if candidate.choices > 1 and candidate.proposal is not None:
                axes += len(candidate.points[0])
                for axis in range(len(candidate.points[0])):
                    here = _along(space, here, c, axis)
        if axes < 2 or space.value(here) - before < SETTLED:
            break
    return here


def _along(space: Space, here: Structure, c: int, axis: int) -> Structure:
    """The best point along one parameter: golden steps between the neighbours that the grid has, then parabolas."""
    candidate = space.candidates[c]
    others = here - {each for each in here if each[0] == c}
    (now,) = (p for owner, p in here if owner == c)
    centre = candidate.points[now]
    low, high = _bracket([point[axis] for point in candidate.points[: candidate.choices]], centre[axis])
    low = max(low, 1.0) if "harmonic" in candidate.names else low
    tried = {centre[axis]: (space.value(here), here)}
    if low == high:
        return here

    def ask(x: float) -> None:
        point = (*centre[:axis], x, *centre[axis + 1 :])
        place = space.grow(c, point)
        if place is not None:
            structure = others | {(c, place)}
            tried[x] = (space.value(structure), structure)

    step_down, step_up = 0.5 * (centre[axis] - low), 0.5 * (high - centre[axis])
    for _ in range(TRIES // 2):
        best = max(tried, key=lambda x: tried[x][0])
        before = tried[best][0]
        for x in (best - step_down, best + step_up):
            if low < x < high and x not in tried:
                ask(x)
        after = max(value for value, _ in tried.values())
        if max(tried, key=lambda x: tried[x][0]) == best:
            vertex = _vertex(best, {x: value for x, (value, _) in tried.items()})
            if vertex is not None and low < vertex < high and vertex not in tried:
                ask(vertex)
            step_down, step_up = 0.5 * step_down, 0.5 * step_up
            worst = min((before - tried[x][0] for x in tried if x != best), default=0.0)
            if worst < SETTLED:
                break
        elif after - before < SETTLED:
            break
    best = max(tried, key=lambda x: tried[x][0])
    if "harmonic" in candidate.names:
        for x in candidate.natural(best):
            if x not in tried:
                ask(x)
            if x in tried and tried[x][0] > tried[best][0] - NATURAL:
                return tried[x][1]
    return tried[best][1]


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
