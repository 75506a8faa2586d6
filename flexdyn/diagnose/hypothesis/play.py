"""Possible half gaps of a joint's backlash, from the deflection of its spring and its load."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from flexdyn.diagnose.equations.equations import Equations
from flexdyn.diagnose.equations.terms import joint_terms

Array = NDArray[np.float64]
HALF_GAP_POINTS = 10
"""Number of points of the grid of half gaps."""
NARROWEST_PLAY, WIDEST_PLAY, WIDEST_MADE_UP_PLAY = 0.003, 0.8, 3.0
"""Ends of the grid in units of the joint's deflection; the last one if the deflection was computed without a gap [1].
"""
SMALLEST_HALF_GAP = 0.05
"""Half gap that is always tried, in the same unit [1]."""


def half_gaps(equations: Equations, j: int, deflection: float) -> list[float]:
    """Half gaps to be tried at a joint [rad or m].

    A gap that is never left would be the same as a missing spring.

    Args:
        equations: of the model.
        j: the joint.
        deflection: nearly the largest one [rad or m].
    """
    if equations.made_up[j] or equations.replayed[j]:
        return [float(gap) for gap in deflection * np.geomspace(NARROWEST_PLAY, WIDEST_MADE_UP_PLAY, HALF_GAP_POINTS)]
    widest = max(_unwound(equations, j), SMALLEST_HALF_GAP * deflection)
    grid = deflection * np.geomspace(NARROWEST_PLAY, WIDEST_PLAY, HALF_GAP_POINTS)
    return [*(float(gap) for gap in grid if gap < widest), widest]


def _unwound(equations: Equations, j: int) -> float:
    """Median of ``theta - q - tau_s/K`` along tau_s, where it is large, by the link's equation [rad or m]."""
    true = equations.true
    left = []
    for along in equations.motions:
        terms = joint_terms(true, true.all_effects, along, j)
        carried = terms.tau_s - (terms.link - along.inverse_dynamics[:, j])
        size = np.abs(carried)
        loaded = size >= np.median(size)
        left.append((np.sign(carried) * along.delta[:, j] - size / true.stiffness[j])[loaded])
    return float(np.median(np.concatenate(left)))
