"""Whether an effect is what its name says, or an imitation of something that the catalogue lacks.

An unexplained rest shows that the robot has an effect without a name. The most similar law of the catalogue explains a
share of it and then stands out from the rest. Let R be the power of an effect's own part over the power of the rest. An
imitation explains the share 1/(1 + 1/R) of the unknown effect. If all shares are equally likely, a share as large or
larger has the probability 1/(1 + R). With prior odds c that a drive has the effect, against something unknown that
resembles it,

    p(genuine) = c (1 + R) / (1 + c (1 + R))
"""

from __future__ import annotations

from collections.abc import Collection, Mapping

import numpy as np
from scipy.linalg import cho_solve

from flexdyn.arrays import Array, Indices
from flexdyn.diagnose.constants import CERTAIN_SIGMAS, NOISE_LEVEL_ERROR, OFTEN, ON_LINKS, PREVALENCE_ODDS, SELDOM
from flexdyn.diagnose.inference.candidate import Candidate
from flexdyn.diagnose.inference.evidence import lower_factor
from flexdyn.diagnose.inference.model_error import ModelError
from flexdyn.diagnose.inference.space import Space, Structure
from flexdyn.diagnose.inference.torque_shares import torque_share
from flexdyn.effects import Effect
from flexdyn.model.uncertain_parameters import DEFAULT_TOLERANCE

GUESSED = ("rotor_inertia",)
"""Numbers that are often wrong, where the file does not say that they are known better than others usually are."""


def genuine(
    candidate: Candidate, share: float, expected: Collection[str] = (), effects: Collection[Effect] = ()
) -> float:
    """Probability that an effect is what its name says.

    Args:
        candidate: the effect and its place.
        share: power of its own part over that of what is left [1].
        expected: kinds of effects that the user expects of this drive.
        effects: of the model as given.
    """
    own = not candidate.law.__module__.startswith("flexdyn.")  # a user who writes a law expects it
    if own or _guessed(candidate) or candidate.kind in expected:
        prior = OFTEN
    elif _unusual(candidate, effects):
        prior = SELDOM
    else:
        prior = (ON_LINKS if candidate.place.get("side") == "link" else PREVALENCE_ODDS)[candidate.law.prevalence]
    odds = prior * (1.0 + min(share, 1e12))
    return odds / (1.0 + odds)


def _guessed(candidate: Candidate) -> bool:
    number = candidate.number
    return number is not None and number.parameter in GUESSED and number.tolerance >= DEFAULT_TOLERANCE


def _unusual(candidate: Candidate, effects: Collection[Effect]) -> bool:
    """Whether a law is seldom missing at this place, however many drives have it.

    The model as given may have it there already, or an encoder's lag is meant where only currents are often late, or
    two drives that are far apart.
    """
    if candidate.proposal is not None and candidate.proposal.seldom:
        return True
    place, alike = candidate.place, {candidate.kind, *candidate.law.contains, *candidate.law.plainer}
    where = {key: name for key, name in place.items() if key != "effect"}
    there = [each for each in effects if all(getattr(each, key, None) == name for key, name in where.items())]
    return any(each.name in alike or candidate.kind in (*each.contains, *each.plainer) for each in there) or (
        bool(candidate.law.late_by) and not place.get("channel", "tau").startswith("tau")
    )


def power_ratios(space: Space, structure: Structure, overstated: Array | float = 0.0) -> dict[int, float]:
    """Of every effect of a structure and every number of the file: own power over that of what is not explained [1].

    The own part of an effect is the part that no other effect of the structure, no number of the file within its
    tolerance and no plainer law that it contains can explain; for a number it is the effect of its displacement that
    they cannot explain. The unexplained part is the residual beyond the sensors' noise in the same equations, if it is
    correlated: white residuals mean a wrong noise level. If this part is zero, it is the share of torque that is left
    over all equations, as far as noise can hide it.

    Args:
        space: of the linearisation.
        structure: in it.
        overstated: squares that the linear equations leave and a fit does not (equations,).
    """
    own = space.estimate(structure)
    columns, mean = space.gram.with_base(own)
    value = dict(zip(columns.tolist(), mean.tolist(), strict=True))
    squares = np.maximum(space.gram.squares(own) - overstated, 0.0)
    below = _undetected(space.noise)
    excess = beyond_noise(space.noise, squares)
    typical, weights = _typical(space, excess), space.gram.weights
    point, found = dict(structure), {}
    numbers = list(space.library.start.factors.values())
    for c in sorted({*point, *range(len(numbers))}):
        mine = space.candidates[c].columns[point[c]] if c in point else np.zeros(0, np.intp)
        does = np.array([value[int(k)] for k in mine])
        if c < len(numbers):  # in every structure within its tolerance, and in this one perhaps beyond
            mine, does = np.array([c, *mine], np.intp), np.array([value[c] + numbers[c] - 1.0, *does])
        whole = weights * (space.matrix.products.sum(mine, does) ** 2).sum(axis=1)
        if not whole.any():  # a number that is where the file has it
            found[c] = 0.0
            continue
        there = whole > 0.01 * whole.max()
        share = torque_share(space.candidates[c], space.matrix.size[mine], does)
        hidden = whole[there].sum() * (typical / share) ** 2 if share > 0.0 else 0.0
        left = max(float((weights * excess)[there].sum()), min(hidden, float((weights * below)[there].sum())))
        found[c] = _own_power(space, structure, c, mine, value, does) / max(left, 1e-9)
    return found


def beyond_noise(noise: ModelError, squares: Array) -> Array:
    """What of white sums of squares (equations,) is more than noise, chance and a wrong level of the noise make."""
    return np.asarray(np.maximum(squares - noise.count - _undetected(noise), 0.0) * (1.0 - 1.0 / noise.times))


def _undetected(noise: ModelError) -> Array:
    """Power beyond noise that chance and a wrong level of the noise may make (equations,)."""
    return np.asarray(NOISE_LEVEL_ERROR * noise.count + CERTAIN_SIGMAS * np.sqrt(2.0 * noise.count * noise.times))


def _typical(space: Space, excess: Array) -> float:
    """Share of torque that is not explained, root mean square over the equations [1].

    A column's white power over the square of its torque's share tells what a share of the torque is in white rows.
    """
    shares, matrix = [], space.matrix
    for e, squares in enumerate(matrix.products.diagonals()):
        k = np.arange(matrix.base, matrix.used)
        k = k[(matrix.of[k] == e) & (matrix.size[k] > 0.0)]
        if len(k):
            shares.append(excess[e] / max(float(np.median(squares[k] / matrix.size[k] ** 2)), 1e-300))
    return float(np.sqrt(np.mean(shares))) if shares else 0.0


def _own_power(
    space: Space, structure: Structure, c: int, mine: Indices, value: Mapping[int, float], does: Array
) -> float:
    """Weighted squares of what a candidate's columns do that all others of a structure cannot, their priors included.

    ``min_b sum_k w_k |X_k does - Z_k b|^2 + b^T Lambda b``: a number that must leave its tolerance for it counts. Where
    a number is so little known that its prior allows it to be negative, b stays where it is positive.
    """
    numbers = list(space.library.start.factors.values())
    others = [k for other in structure if other[0] != c for k in space.candidates[other[0]].columns[other[1]].tolist()]
    plain = [k for each in space.contained[c] for k in space.candidates[each].columns[0].tolist()]
    columns = np.setdiff1d(np.array([*range(len(numbers)), *others, *plain], np.intp), mine)
    weights, products = space.gram.weights, space.matrix.products
    G = np.diag(space.matrix.prior.precision[columns]) + np.tensordot(weights, products.of(columns, columns), 1)
    b = np.tensordot(weights, products.of(columns, mine), 1) @ does
    power = float(does @ np.tensordot(weights, products.of(mine, mine), 1) @ does)
    least = np.full(len(columns), -np.inf)
    for k in set(space.loose) & set(columns.tolist()):
        least[np.searchsorted(columns, k)] = min(-numbers[k] - value[k], 0.0)
    x = at_least(G, b, least)
    return max(power - float(x @ (2.0 * b - G @ x)), 0.0)


def at_least(G: Array, b: Array, least: Array) -> Array:
    """Minimum of ``x^T G x - 2 b^T x`` with lower bounds (k,): what would fall below its bound stays there."""
    x, free = least.copy(), np.ones(len(b), bool)
    while free.any():
        right = b[free] - G[np.ix_(free, ~free)] @ x[~free]
        x[free] = cho_solve((lower_factor(G[np.ix_(free, free)]), True), right)
        below = free & (x < least)
        if not below.any():
            break
        x[below], free = least[below], free & ~below
    return x
