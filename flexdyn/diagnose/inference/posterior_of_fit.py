"""Log posterior of a structure by its fit, which is exact where a linearisation only promises."""

from __future__ import annotations

import math

import numpy as np

from flexdyn.arrays import Array, Flags
from flexdyn.diagnose.constants import CERTAIN_SIGMAS, NOISE_LEVEL_ERROR
from flexdyn.diagnose.equations.equations import Equations
from flexdyn.diagnose.hypothesis.chord import chord_fit
from flexdyn.diagnose.hypothesis.estimate import fit
from flexdyn.diagnose.hypothesis.fitted import Fit
from flexdyn.diagnose.hypothesis.hypothesis import Hypothesis
from flexdyn.diagnose.hypothesis.linear import priors
from flexdyn.diagnose.hypothesis.workspace import Workspace
from flexdyn.diagnose.inference.space import Space, Structure
from flexdyn.diagnose.inference.whitening import Tempered
from flexdyn.errors import SimulationError

STEPS_OF_A_FIT = 8
"""Gauss-Newton steps at most of the fit of a structure that a linearisation prefers or that is tried beside another."""


def log_posterior(space: Space, structure: Structure, made: Fit) -> float:
    """``log likelihood of what the fit leaves + log priors at its numbers + Occam's factor``, not normalised.

    The last one is that of the linear equations.
    """
    own = space.estimate(structure)
    gained = space.log_gained(made.hypothesis.effects)
    density = _log_density(space, made.hypothesis, made.equations, made.space)
    return density + gained + space.log_volume(structure, own) + space.log_large(structure, own)


def log_density_at(space: Space, there: Hypothesis, work: Workspace) -> float:
    """Of a hypothesis as it is, with the weights of a workspace; -inf where its equations are not finite."""
    try:
        return _log_density(space, there, work.equations.of(there.model()), work)
    except SimulationError:
        return -math.inf


def _log_density(space: Space, there: Hypothesis, at: Equations, work: Workspace) -> float:
    """Log likelihood of what a hypothesis leaves, under the model error of a linearisation, and of the priors.

    These are of the numbers and of the offsets of the encoders: an offset may take up a torque that is missing.
    """
    centre, sigma = priors(there, work)
    squares, of_offsets = squares_left(at, work)
    return space.noise.log_likelihood(squares) - 0.5 * (float(np.sum((centre / sigma) ** 2)) + of_offsets)


def squares_left(at: Equations, work: Workspace, hidden: Flags | bool = False) -> tuple[Array, float]:
    """Sums of the squared rows of each equation that are not hidden, in units of the sensors' noise (equations,).

    And that of the encoders' offsets, over their variances.
    """
    weights = work.at(at)
    white, of_offsets = weights.without_offsets(at.residual)
    squares = (np.where(hidden, 0.0, white).reshape(-1, len(at.kinds)) ** 2).sum(axis=0)
    if isinstance(weights.whiten, Tempered):
        squares = squares * weights.whiten.error.scale**2 * weights.whiten.error.times
    return np.asarray(squares), of_offsets


def leaves_more_than_noise(made: Fit) -> bool:
    """Whether a fit leaves more than noise, chance and a misjudged level of the noise make."""
    squares, _ = squares_left(made.equations, made.space)
    count = (~made.space.bare.mask).reshape(-1, len(squares)).sum(axis=0)
    return bool((squares > (1.0 + NOISE_LEVEL_ERROR) * count + CERTAIN_SIGMAS * np.sqrt(2.0 * count)).any())


def noise_would_gain(space: Space, made: Fit) -> float:
    """Log likelihood that noise alone has beyond what a fit leaves, under the model error of a linearisation."""
    squares, _ = squares_left(made.equations, made.space)
    return space.noise.log_likelihood(np.minimum(squares, space.noise.count)) - space.noise.log_likelihood(squares)


def fit_if_likely(
    space: Space, structure: Structure, start: Hypothesis, base: Fit, least: float
) -> tuple[float, Fit | None]:
    """Log posterior of a structure by its fit, and the fit, which ends early where it will not reach a least value.

    The first steps keep the slopes of another fit. What they reach, and what they promise beyond it, tells whether the
    fit goes on with its own slopes.

    Args:
        space: of the linearisation.
        structure: to be fitted.
        start: its first values.
        base: a fit near it, under whose weights this one is made.
        least: log posterior that it must reach to be of interest.
    """
    try:
        made = chord_fit(start, base)
    except SimulationError:  # nothing can be computed there
        return -math.inf, None

    def hopeless(made: Fit) -> bool:
        """Whether even what its step promises does not reach the least value."""
        return log_posterior(space, structure, made) + 0.5 * (made.reached - made.chi2) <= least

    if not hopeless(made):
        made = fit(made.hypothesis, base.space, steps=STEPS_OF_A_FIT, hopeless=hopeless)
    return log_posterior(space, structure, made), made


def carried_on(space: Space, structure: Structure, made: Fit) -> Fit:
    """A fit that went on in the way in which others are tried beside it, where that makes it more likely."""
    value, other = fit_if_likely(space, structure, made.hypothesis, made, log_posterior(space, structure, made))
    return made if other is None or value <= log_posterior(space, structure, made) else other
