"""How the innovations of windows change with the numbers of a hypothesis."""

from __future__ import annotations

import dataclasses

import numpy as np
from numpy.typing import NDArray

from flexdyn.diagnose.hypothesis.hypothesis import Hypothesis
from flexdyn.diagnose.shooting.gap import Shot

Array = NDArray[np.float64]
SCALED_STEP = 0.1
"""Step of the differences, in scales of the fit; a factor's in the part of its tolerance that this is."""


def slopes(here: Hypothesis, shot: Shot, scales: tuple[float, ...]) -> Array:
    """Differences of the whitened windows by every number, from the same first states (rows, numbers).

    Args:
        here: the hypothesis that was simulated.
        shot: its windows.
        scales: of the effects' unknowns.
    """
    white = shot.whitened().ravel()
    columns = []
    for k in range(len(here.factors) + len(scales)):
        stepped, step = _stepped(here, k, scales)
        columns.append((shot.whitened(stepped.seen()).ravel() - white) / step)
    return np.stack(columns, axis=1)


def _stepped(here: Hypothesis, k: int, scales: tuple[float, ...]) -> tuple[Hypothesis, float]:
    """The hypothesis with one number moved, and by how much."""
    numbers = len(here.factors)
    if k < numbers:
        number, factor = list(here.factors.items())[k]
        step = SCALED_STEP * max(number.tolerance, 1e-3)
        return dataclasses.replace(here, factors={**here.factors, number: factor + step}), step
    effect, name = here.unknowns()[k - numbers]
    changed = effect.replace(**{name: getattr(effect, name) + SCALED_STEP * scales[k - numbers]})
    effects = tuple(changed if each is effect else each for each in here.effects)
    return dataclasses.replace(here, effects=effects), SCALED_STEP
