"""The difference between two hypotheses in simulated windows of a future motion.

Where a velocity changes its sign, the equations are masked, because dry friction is undetermined there; simulated
windows include these times.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from flexdyn.diagnose.experiment.apart import Known, Refit, laden
from flexdyn.diagnose.hypothesis.hypothesis import Hypothesis, moved
from flexdyn.diagnose.shooting.gap import Shot, shoot
from flexdyn.diagnose.simulated.slopes import slopes
from flexdyn.effects import Payload

Array = NDArray[np.float64]


def as_made(shot: Shot) -> Refit:
    """The residuals of the hypothesis that made the motion."""
    white = shot.whitened().ravel()
    return Refit(np.zeros((len(white), 1)), white, len(white))


def windowed(known: Known, shot: Shot, load: Payload | None, worth: float) -> Refit:
    """Fit another hypothesis to the windows of a motion, with the previous information about its numbers.

    Args:
        known: the hypothesis.
        shot: the windows, with the hypothesis that made the motion.
        load: payload of the arm.
        worth: sum of squares below which neither its first states nor its numbers are fitted.
    """
    first = laden(known.fitted.hypothesis, load)
    scales = known.fitted.scales
    white = shot.whitened(first.seen()).ravel()
    if white @ white < worth:
        return Refit(np.zeros((len(white), 1)), white, len(white))
    shot = shoot(first.seen(), shot.windows)
    white = shot.whitened().ravel()
    J = slopes(first, shot, scales)
    root = known.marginal(J.shape[1])
    return Refit(np.vstack([J, root]), np.concatenate([white, np.zeros(len(root))]), len(white))


def bent(known: Known, refit: Refit, load: Payload | None) -> Hypothesis:
    """The hypothesis with the numbers that a refit over windows gives it."""
    first = laden(known.fitted.hypothesis, load)
    count = len(first.factors) + len(known.fitted.scales)
    return moved(first, refit.step(), known.fitted.scales) if refit.X.shape[1] == count else first
