"""How far the numbers of a finding are known, over the structures that share the probability.

A fit knows its numbers as if its structure were certain. Whether other effects are there is not certain, and those move
the numbers. So a number has a mixture of distributions: one around its value in each structure, with the probability of
that structure (Hoeting, Madigan, Raftery and Volinsky, Statistical Science 14, 1999). The reported interval
x +- w holds 95 % of the mixture:

    sum_k p_k (Phi((x + w - x_k)/s) - Phi((x - w - x_k)/s)) = 0.95                       (8)

x and s are the value and the standard deviation of the corrected model's fit, x_k - x by the linear equations.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from scipy.optimize import brentq
from scipy.special import ndtr

from flexdyn.arrays import Array
from flexdyn.diagnose.decision.corrected import Corrected, is_there
from flexdyn.diagnose.inference.space import Structure
from flexdyn.diagnose.inference.structure_model import effect_of, hypothesis_of
from flexdyn.diagnose.report.suspects import CONFIDENCE

NEGLIGIBLE_MASS = 1e-3
"""Probability of a structure from which its numbers count [1]: the rarer ones hardly change an interval."""
FACTOR_NAME = "factor"
"""The number of a finding that is a number of the file."""


@dataclass(frozen=True, eq=False)
class Shifts:
    """How far a number is from its value in the corrected model, in the structures that have it.

    Attributes:
        shift: in the unit of the number (structures,).
        probability: of the structures, normalised (structures,).
    """

    shift: Array
    probability: Array

    def widened(self, std: float) -> float:
        """Standard deviation of a normal distribution whose 95 % interval is that of the mixture.

        Args:
            std: of the number in a single structure.
        """
        inside = float(ndtr(CONFIDENCE) - ndtr(-CONFIDENCE))
        farthest = float(np.abs(self.shift).max())
        if not std >= 0.0 or farthest == 0.0:  # it is not known, or nothing is added to it
            return std
        s = max(std, 1e-9 * farthest)

        def beyond(w: float) -> float:
            """What the interval of this half-width holds beyond 95 %."""
            held = ndtr((w - self.shift) / s) - ndtr((-w - self.shift) / s)
            return float(self.probability @ held) - inside

        return max(std, float(brentq(beyond, 0.0, farthest + 2.0 * CONFIDENCE * s)) / CONFIDENCE)


NumberShifts = dict[tuple[int, str], Shifts]
"""By candidate and parameter."""


def shifts_of_numbers(found: Corrected) -> NumberShifts:
    """Numbers of every name in the structures that have it, by the linear equations.

    Args:
        found: the corrected model.

    Returns:
        by candidate and parameter; what structures do not tell is not in it.
    """
    masses = found.masses
    here = np.isfinite(masses.log) & (masses.probability >= NEGLIGIBLE_MASS)  # others have grid points elsewhere
    kept = [(masses.structures[k], float(masses.probability[k])) for k in np.flatnonzero(here).tolist()]
    made: dict[tuple[int, str], list[tuple[float, float]]] = {}
    own = _sizes_in(found, _of_corrected(found, kept[0][0])) if kept else {}
    for structure, p in kept:
        for key, value in _sizes_in(found, structure).items():
            if key in own and math.isfinite(value - own[key]):
                made.setdefault(key, []).append((value - own[key], p))
    arrays = {key: np.array(each).T for key, each in made.items()}
    return {key: Shifts(shift, p / p.sum()) for key, (shift, p) in arrays.items()}


def _of_corrected(found: Corrected, best: Structure) -> Structure:
    """The part of the most probable structure that the corrected model has."""
    return frozenset((c, p) for c, p in best if is_there(found.candidates[c], found.hypothesis))


def _sizes_in(found: Corrected, structure: Structure) -> dict[tuple[int, str], float]:
    """Sizes of the names that a structure has, with its coefficients by the linear equations."""
    made = hypothesis_of(found.space, structure, whole=True)
    there, numbers = {c for c, _ in structure}, {}
    for c in sorted(found.named & there):
        candidate = found.candidates[c]
        if candidate.number is not None:
            numbers[c, FACTOR_NAME] = made.factors[candidate.number]
        elif (effect := effect_of(candidate, made)) is not None:
            numbers |= {(c, name): float(getattr(effect, name)) for name in effect.neutral}
    return numbers
