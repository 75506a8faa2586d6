"""How well the final fit is determined, in the words that lmfit prints."""

from __future__ import annotations

import math

import numpy as np

from flexdyn.diagnose.decision.notes import number_words
from flexdyn.diagnose.hypothesis.fitted import Fit
from flexdyn.diagnose.report.record import Statistics

CORRELATION_TOLD, MOST_CORRELATIONS = 0.1, 40
"""Correlations that are told: none below, no more than so many."""
METHOD = "Gauss-Newton, weighted by noise and model error, with the stated tolerances as priors"


def statistics(made: Fit) -> Statistics:
    """Of the corrected model's fit.

    Args:
        made: the fit; its correlations are those of the last linear problem.
    """
    problem = made.free or made.regression
    points, variables = problem.rows, problem.X.shape[1]
    chi_square = problem.data_chi2
    log = points * math.log(max(chi_square, 1e-300) / points)
    names = number_words(made.hypothesis)
    covariance = problem.covariance[: len(names), : len(names)]
    spread = np.sqrt(np.diag(covariance))
    alike = covariance / np.maximum(np.outer(spread, spread), 1e-300)
    first, second = np.triu_indices(len(names), 1)
    pairs = [
        (names[i], names[j], float(alike[i, j]))
        for i, j in zip(first.tolist(), second.tolist(), strict=True)
        if abs(alike[i, j]) >= CORRELATION_TOLD
    ]
    pairs.sort(key=lambda pair: -abs(pair[2]))
    return Statistics(
        METHOD,
        points,
        variables,
        chi_square,
        chi_square / max(1, points - variables),
        log + 2.0 * variables,
        log + math.log(points) * variables,
        tuple(pairs[:MOST_CORRELATIONS]),
    )
