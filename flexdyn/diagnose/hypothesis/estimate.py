"""A model with numbers moved and effects added, fitted to the equations by Gauss-Newton."""

from __future__ import annotations

import dataclasses
import math

from flexdyn.diagnose.hypothesis.fitted import Fit, Workspace
from flexdyn.diagnose.hypothesis.hypothesis import Hypothesis, moved
from flexdyn.diagnose.hypothesis.linear import linearised, reached
from flexdyn.effects import SensorOffset
from flexdyn.errors import SimulationError

NEGLIGIBLE_DROP = 0.05
"""Drop of chi^2, in units of what is left of a row, below which another step is not worth its time."""
NEGLIGIBLE_DROP_SHARE = 1e-4
"""The same as a share of what is left over noise: laws are told apart by much more than that while one is missing."""
WATCHDOG_STEPS = 2
"""Steps that may go on from where chi^2 rose: numbers that multiply one another lie along a bent valley, whose floor a
straight step leaves and the next one finds again (the watchdog of Chamberlain et al., 1982)."""
LITTLE = 2
"""Whole steps one after the other that may change less than a step is worth though they promised more: what bends at
reversals has slopes that no step keeps."""
SHORTENED_STEP = 0.3
"""Share of a step that is tried where all of it was too much."""


def fit(start: Hypothesis, space: Workspace, steps: int = 12) -> Fit:
    """Gauss-Newton from a hypothesis: every number of the file within its prior, every unknown of its effects.

    Args:
        start: where to begin, or there with its numbers back within their tolerance, where that leaves less.
        space: data, weights and the derivatives that do not change.
        steps: at most so many.

    Raises:
        SimulationError: where it begins, the equations are not finite.
    """
    best = base = _begun(start, space)
    share, ahead, little = 1.0, 0, 0
    for _ in range(steps - 1):
        worth = max(
            NEGLIGIBLE_DROP * max(1.0, best.reduced), NEGLIGIBLE_DROP_SHARE * (best.regression.data_chi2 - space.rows)
        )
        if best.reached - best.chi2 < worth or little == LITTLE:
            break
        watched = share == 1.0 and ahead < WATCHDOG_STEPS
        made = _after(base, share, math.inf if watched else best.reached)
        if made is None:
            base, share = best, SHORTENED_STEP * share
            continue
        little = little + 1 if share == 1.0 and abs(best.reached - made.reached) < worth else 0
        if made.reached <= best.reached:
            ahead = 0 if share == 1.0 else ahead  # where it did not help it is not tried again
            best, base, share = made, made, min(1.0, share / SHORTENED_STEP)
        elif watched and made.chi2 < best.reached:
            base, ahead = made, ahead + 1
        else:
            base, share = best, SHORTENED_STEP * share
    return _counted(best, space)


def _begun(start: Hypothesis, space: Workspace) -> Fit:
    """The problem where a fit begins: what bent the numbers may be gone by now, or still be there."""
    held = start.tolerated()
    if held.factors == start.factors:
        return linearised(start, space)
    at, back = (space.equations.of(each.model()) for each in (start, held))
    if reached(start, at, space) < reached(held, back, space):
        return linearised(start, space, None, at)
    return linearised(held, space, None, back)


def _after(base: Fit, share: float, most: float) -> Fit | None:
    """The problem after a share of a step; None where more is left than may be, for which no slopes are taken."""
    trial = moved(base.hypothesis, share * base.step, base.scales)
    try:
        at = base.space.equations.of(trial.model())
        if most < math.inf and reached(trial, at, base.space) > most:
            return None
        return linearised(trial, base.space, base, at)
    except SimulationError:  # too far
        return None


def _counted(made: Fit, space: Workspace) -> Fit:
    """The fit with the offsets of its encoders in its hypothesis."""
    first = made.regression.X.shape[1] - space.nuisance.shape[1]
    values = made.regression.values[first : first + len(space.channels)]
    counts = tuple(SensorOffset(name, offset=float(x)) for name, x in zip(space.channels, values, strict=True))
    return dataclasses.replace(made, hypothesis=dataclasses.replace(made.hypothesis, counts=counts))
