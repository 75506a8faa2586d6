"""How far two hypotheses part over windows of a motion that was not made yet: what the equations must leave out.

Where a velocity changes its sign the equations say nothing, as dry friction may be anything there; simulated windows go
through it.
"""

from __future__ import annotations

import dataclasses

import numpy as np
from numpy.typing import NDArray

from flexdyn.diagnose.experiment.apart import Known, Refit, laden
from flexdyn.diagnose.hypothesis.hypothesis import Hypothesis, moved
from flexdyn.diagnose.shooting.gap import Shot, shoot
from flexdyn.effects import Payload

Array = NDArray[np.float64]
STEP = 0.1
"""Of the differences, in scales of the fit; a factor's in the part of its tolerance that this is."""


def as_made(shot: Shot) -> Refit:
    """What the hypothesis that made the motion leaves of it."""
    white = shot.whitened().ravel()
    return Refit(np.zeros((len(white), 1)), white, len(white))


def windowed(known: Known, shot: Shot, load: Payload | None, worth: float) -> Refit:
    """Another hypothesis over the windows of a motion, its numbers bent as far as what is known about them lets it.

    Args:
        known: the hypothesis.
        shot: the windows, under the hypothesis that made the motion.
        load: that the arm carries.
        worth: sum of squares below which neither its first states nor its numbers need be bent.
    """
    first = laden(known.fitted.hypothesis, load)
    scales = known.fitted.scales
    white = shot.whitened(first.seen()).ravel()
    if white @ white < worth:
        return Refit(np.zeros((len(white), 1)), white, len(white))
    shot = shoot(first.seen(), shot.windows)
    white = shot.whitened().ravel()
    numbers, columns = len(first.factors), []
    for k in range(numbers + len(scales)):
        stepped, step = _stepped(first, k, numbers, scales)
        columns.append((shot.whitened(stepped.seen()).ravel() - white) / step)
    J, root = np.stack(columns, axis=1), known.marginal(len(columns))
    return Refit(np.vstack([J, root]), np.concatenate([white, np.zeros(len(root))]), len(white))


def bent(known: Known, refit: Refit, load: Payload | None) -> Hypothesis:
    """The hypothesis with the numbers that a refit over windows gives it."""
    first = laden(known.fitted.hypothesis, load)
    count = len(first.factors) + len(known.fitted.scales)
    return moved(first, refit.step(), known.fitted.scales) if refit.X.shape[1] == count else first


def _stepped(first: Hypothesis, k: int, numbers: int, scales: tuple[float, ...]) -> tuple[Hypothesis, float]:
    """The hypothesis with one number moved, and by how much."""
    if k < numbers:
        number, factor = list(first.factors.items())[k]
        step = STEP * max(number.tolerance, 1e-3)
        return dataclasses.replace(first, factors={**first.factors, number: factor + step}), step
    effect, name = first.unknowns()[k - numbers]
    changed = effect.replace(**{name: getattr(effect, name) + STEP * scales[k - numbers]})
    effects = tuple(changed if each is effect else each for each in first.effects)
    return dataclasses.replace(first, effects=effects), STEP
