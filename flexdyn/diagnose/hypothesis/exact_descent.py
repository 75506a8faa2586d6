"""Fits continued along differences of what they minimise, where the slopes of their rows do not lead down."""

from __future__ import annotations

import dataclasses
import math

import numpy as np

from flexdyn.arrays import Array, Indices
from flexdyn.diagnose.constants import LEAST_DESCENT
from flexdyn.diagnose.hypothesis.estimate import fit
from flexdyn.diagnose.hypothesis.fitted import Fit
from flexdyn.diagnose.hypothesis.hypothesis import Hypothesis, moved
from flexdyn.diagnose.hypothesis.linear import reached
from flexdyn.errors import SimulationError

DESCENTS = 8
"""Steps along differences, at most."""
LEVENBERG_FACTORS = (0.0, 1e-6, 1e-4, 1e-2, 1.0, 100.0)
"""Levenberg's and Marquardt's factor of the curvatures' diagonal, until a step leads down [1]."""
DIFFERENCE = 0.3
"""Distance over which a difference is taken, in standard deviations of the number if all others were known [1]."""


def descended(made: Fit) -> Fit:
    """A fit, continued with ``step = -(H + lambda diag H)^-1 g/2``: its information H, and the gradient g of chi^2.

    The gradient is by central differences. Gauss-Newton takes the weights for constant. Where they follow the numbers,
    as with springs of which one side is measured and torques that no law explains, its steps may promise much and lead
    nowhere. The fit is stationary if no step along the differences leads down.

    Args:
        made: a fit that its own slopes do not improve.
    """
    for _ in range(DESCENTS):
        known = made.regression.X.shape[1] - made.regression.nuisances
        free = np.setdiff1d(np.arange(known), made.held)
        H, gradient = _information(made)[np.ix_(free, free)], _gradient(made, free)
        lower = _lower(made, free, H, gradient)
        if lower is None:
            return dataclasses.replace(made, stationary=True)
        made = fit(lower, made.space, steps=1)
    return made


def _information(made: Fit) -> Array:
    """Of the numbers and unknowns, the nuisances fitted beside them."""
    left, whole = made.regression, made.regression.with_priors
    known = left.X.shape[1] - left.nuisances
    columns, nuisance = whole[:, :known], whole[:, known:]
    apart = columns - nuisance @ np.linalg.lstsq(nuisance, columns, rcond=1e-12)[0] if left.nuisances else columns
    return np.asarray(apart.T @ apart)


def _gradient(made: Fit, free: Indices) -> Array:
    """Of chi^2 by some columns of a fit."""
    left = made.regression
    inside = (left.X**2).sum(axis=0) + 1.0 / left.sigma**2
    found = []
    for k in free.tolist():
        ahead = np.zeros(left.X.shape[1])
        ahead[k] = DIFFERENCE / math.sqrt(inside[k])
        up, down = (_reached(moved(made.hypothesis, way * ahead, made.scales), made) for way in (1.0, -1.0))
        found.append((up - down) / (2.0 * ahead[k]) if math.isfinite(up - down) else 0.0)
    return np.array(found)


def _lower(made: Fit, free: Indices, H: Array, gradient: Array) -> Hypothesis | None:
    """The hypothesis after the least damped step that leads down; None: none does."""
    step, scale = np.zeros(made.regression.X.shape[1]), np.diag(np.maximum(np.diag(H), 1e-300))
    for damping in LEVENBERG_FACTORS:
        step[free] = -0.5 * np.linalg.lstsq(H + damping * scale, gradient, rcond=1e-12)[0]
        trial = moved(made.hypothesis, step, made.scales)
        if _reached(trial, made) < made.reached - LEAST_DESCENT:
            return trial
    return None


def _reached(trial: Hypothesis, made: Fit) -> float:
    try:
        return reached(trial, made.space.equations.of(trial.model()), made.space)
    except SimulationError:
        return math.inf
