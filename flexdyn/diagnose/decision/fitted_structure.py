"""A structure that was fitted, and its odds to another one by what the data and the prior of places tell."""

from __future__ import annotations

import dataclasses
import math
from dataclasses import dataclass

import numpy as np

from flexdyn.arrays import Flags
from flexdyn.diagnose.constants import EVEN_ODDS_WINDOW
from flexdyn.diagnose.hypothesis.fitted import Fit
from flexdyn.diagnose.hypothesis.linear import priors
from flexdyn.diagnose.inference.posterior_of_fit import squares_left
from flexdyn.diagnose.inference.space import Space, Structure
from flexdyn.diagnose.inference.structure_model import effect_of

LARGEST_LOG_ODDS = 300.0
"""Larger ones are certainty."""


@dataclass(frozen=True, eq=False)
class FittedStructure:
    """A structure that was fitted.

    Attributes:
        structure: candidates with their grid points.
        value: log posterior without the rows that passages hide.
        likelihood: log likelihood without them, with what the user states and the encoders' rounding makes unlikely.
        promised: log posterior with them.
        numbers: unknowns of its effects, and numbers of the file that are out of tolerance.
    """

    structure: Structure
    value: float
    likelihood: float
    promised: float
    numbers: int

    @classmethod
    def of(cls, space: Space, structure: Structure, value: float, made: Fit, hidden: Flags) -> FittedStructure:
        """Of a fit and its log posterior, with Occam's factor of numbers between the points of their grid.

        Where a joint with a computed position begins or ends to stick, all rows contain what its friction does at an
        uncertain instant. They do not tell one law of friction from another.
        """
        (left, of_offsets), (seen, _) = (squares_left(made.equations, made.space, each) for each in (False, hidden))
        whole, shown = map(space.noise.log_likelihood, (left, seen))
        value_shown = value - whole + shown + _log_between_points(space, structure, made)
        numbers = len(made.hypothesis.unknowns()) + len(made.hypothesis.freed)
        centre, sigma = (each[: len(made.hypothesis.factors)] for each in priors(made.hypothesis, made.space))
        stated = of_offsets + float(np.sum((centre / sigma) ** 2))
        return cls(structure, value_shown, shown - 0.5 * stated, value, numbers)

    def odds_to(self, other: FittedStructure) -> tuple[Structure, frozenset[int], float]:
        """This structure, the candidates of another one, and the odds to that."""
        whole = frozenset(c for c, _ in other.structure)
        return self.structure, whole, math.exp(min(self.value - other.value, LARGEST_LOG_ODDS))

    def beside(self, other: FittedStructure, space: Space) -> FittedStructure:
        """The same with the prior odds of places to another structure, if the data do not tell the two apart.

        That is so if they have as many numbers, and a ratio of likelihoods below 3. Widths of priors are choices, and
        no name rests on them alone.
        """
        if self.numbers != other.numbers or abs(self.likelihood - other.likelihood) > EVEN_ODDS_WINDOW:
            return self
        places = space.places.log_prior(self.structure) - space.places.log_prior(other.structure)
        return dataclasses.replace(self, value=other.value + places)


def _log_between_points(space: Space, structure: Structure, made: Fit) -> float:
    """Occam's factor of nonlinear numbers that a fit has moved between the points of their grid.

    ``log(n) + sum of log(sigma / sigma_prior)``: the prior ``1/n`` of one of n points does not count, as a fit does not
    stay at a point. The effects at which the linear equations stand have this factor there.
    """
    sigma = np.sqrt(np.diag(made.regression.covariance))
    first, unknowns, total = len(made.hypothesis.factors), made.hypothesis.unknowns(), 0.0
    for c, _ in structure:
        candidate = space.candidates[c]
        effect = effect_of(candidate, made.hypothesis)
        if candidate.proposal is None or candidate.choices == 1 or candidate.law.cycles or effect is None:
            continue
        places = [
            first + k for k, (each, name) in enumerate(unknowns) if each is effect and name in candidate.proposal.axes
        ]
        if places and all(0.0 < sigma[k] < made.regression.sigma[k] < math.inf for k in places):
            grid = {tuple(point[k] for k in candidate.moved_axes) for point in candidate.proposal.grid}
            total += math.log(len(grid)) + float(np.log(sigma[places] / made.regression.sigma[places]).sum())
    return total
