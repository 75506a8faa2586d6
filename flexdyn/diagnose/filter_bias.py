"""What the filter in front of the laws does to the numbers: seen by a second fit behind a wider one."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
from numpy.typing import NDArray

from flexdyn.diagnose.equations import Equations
from flexdyn.diagnose.estimate import fit
from flexdyn.diagnose.filters import FIRST, Filters
from flexdyn.diagnose.fitted import Fit
from flexdyn.diagnose.hypothesis import Hypothesis
from flexdyn.diagnose.refine import Refined, of_fit
from flexdyn.diagnose.workspace import Unweighted, weighed

Array = NDArray[np.float64]
WIDER = math.sqrt(2.0)
"""Factor on the first filter's width: what it bends grows with the square, so the difference is what it bent before."""
STEPS = 4
"""Gauss-Newton steps of the second fit."""


def with_filter_bias(made: Fit) -> Refined:
    """The numbers of a fit with standard deviations that hold what its first filter bends.

    Laws with corners see a motion that the first filter has rounded, which no noise explains. A filter of twice the
    variance rounds twice as much, so the change of the numbers is an estimate of the error (Richardson), and goes into
    the spread: ``std^2 + change^2``.

    Args:
        made: the last fit to the equations.
    """
    numbers, space = of_fit(made), made.space
    dt = space.equations.data[0].dt
    first = Filters.of_rate(dt, first=WIDER * max(FIRST, 1.25 * dt)).first
    filters = dataclasses.replace(space.equations.filters, first=first)
    wider = Equations(space.equations.model, space.equations.data, filters, space.equations.stiffness)
    behind = dataclasses.replace(weighed(Unweighted.of(wider, made.hypothesis), space.noise), temper=space.temper)
    again = fit(made.hypothesis, behind, STEPS)
    change = _values(again.hypothesis) - _values(made.hypothesis)
    return dataclasses.replace(numbers, std=np.hypot(numbers.std, np.where(np.isfinite(change), change, 0.0)))


def _values(hypothesis: Hypothesis) -> Array:
    """Factors of the file's numbers and unknowns of the effects, in the order of their spread."""
    unknowns = [getattr(effect, name) for effect, name in hypothesis.unknowns()]
    return np.array([*hypothesis.factors.values(), *unknowns])
