"""Fit a model with free numbers and additional effects to the equations by Gauss-Newton."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable

from flexdyn.diagnose.hypothesis.fitted import Fit
from flexdyn.diagnose.hypothesis.hypothesis import Hypothesis, count_of, moved
from flexdyn.diagnose.hypothesis.linear import linearised, reached
from flexdyn.diagnose.hypothesis.workspace import Workspace
from flexdyn.errors import SimulationError

NEGLIGIBLE_DROP = 0.05
"""If chi^2 decreases by less, in units of a row's mean square, another step is not worth its time [1]."""
NEGLIGIBLE_DROP_SHARE = 1e-4
"""The same as a share of the excess over noise [1]: while a law is missing, differences of laws are much larger."""
WATCHDOG_STEPS = 2
"""Number of steps that may follow a rise of chi^2: for numbers that multiply one another, chi^2 has a curved valley; a
straight step leaves it, and the next one returns to it (the watchdog method of Chamberlain et al., 1982).
"""
LITTLE = 2
"""Number of consecutive full steps with a smaller decrease than predicted, after which the fit ends: at reversals the
slopes change with every step.
"""
SHORTENED_STEP = 0.3
"""Share of a step that is tried if the full step was too long [1]."""


def fit(
    start: Hypothesis, space: Workspace, steps: int = 12, *, hopeless: Callable[[Fit], bool] = lambda _: False
) -> Fit:
    """Fit a hypothesis by Gauss-Newton: every number of the file with its prior, every unknown of its effects.

    Args:
        start: first values; if it leaves less, the start is the same with its numbers back within their tolerance.
        space: data, weights and the derivatives that do not change.
        steps: largest number of steps.
        hopeless: whether the best problem so far promises too little for another step.

    Raises:
        SimulationError: the equations are not finite at the start.
    """
    best = base = _begun(start, space)
    share, ahead, little = 1.0, 0, 0
    for _ in range(steps - 1):
        worth = max(
            NEGLIGIBLE_DROP * max(1.0, best.reduced), NEGLIGIBLE_DROP_SHARE * (best.regression.data_chi2 - space.rows)
        )
        if best.reached - best.chi2 < worth or little == LITTLE or hopeless(best):
            break
        watched = share == 1.0 and ahead < WATCHDOG_STEPS
        made = _after_share(base, share, math.inf if watched else best.reached)
        if made is None:
            base, share = best, SHORTENED_STEP * share
            continue
        little = little + 1 if share == 1.0 and abs(best.reached - made.reached) < worth else 0
        if made.reached <= best.reached:
            ahead = 0 if share == 1.0 else ahead  # if it did not help, it is not tried again
            best, base, share = made, made, min(1.0, share / SHORTENED_STEP)
        elif watched and made.chi2 < best.reached:
            base, ahead = made, ahead + 1
        else:
            base, share = best, SHORTENED_STEP * share
    return _counted(best, space)


def _begun(start: Hypothesis, space: Workspace) -> Fit:
    """The problem at the start of a fit, with the present numbers or with numbers back within their tolerance."""
    held = start.tolerated()
    if held.factors == start.factors:
        return linearised(start, space)
    at, back = (space.equations.of(each.model()) for each in (start, held))
    if reached(start, at, space) < reached(held, back, space):
        return linearised(start, space, None, at)
    return linearised(held, space, None, back)


def _after_share(base: Fit, share: float, most: float) -> Fit | None:
    """The problem after a share of a step; None, without computing slopes, if the residual exceeds a bound."""
    trial = moved(base.hypothesis, share * base.step, base.scales)
    try:
        at = base.space.equations.of(trial.model())
        if most < math.inf and reached(trial, at, base.space) > most:
            return None
        return linearised(trial, base.space, base, at)
    except SimulationError:  # too far
        return None


def _counted(made: Fit, space: Workspace) -> Fit:
    """The fit with the fitted offsets of its encoders in the hypothesis."""
    first = made.regression.X.shape[1] - space.bare.unknown.shape[1]
    values = made.regression.values[first : first + len(space.bare.channels)]
    counts = tuple(count_of(name, float(x)) for name, x in zip(space.bare.channels, values, strict=True))
    return dataclasses.replace(made, hypothesis=dataclasses.replace(made.hypothesis, counts=counts))
