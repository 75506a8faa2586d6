"""Fits under the model error that they leave; the calibrated model: the file's numbers alone, within tolerance."""

from __future__ import annotations

import dataclasses

from flexdyn.diagnose.hypothesis.estimate import fit
from flexdyn.diagnose.hypothesis.fitted import Fit
from flexdyn.diagnose.hypothesis.hypothesis import Hypothesis
from flexdyn.diagnose.hypothesis.workspace import Workspace
from flexdyn.diagnose.inference.weights import error_of, tempered

WEIGHTINGS, STEPS = 4, 4
"""Fits, each with weights by the model error that the last one leaves, and steps of each."""


def calibrated(plain: Workspace, start: Hypothesis) -> Fit:
    """Fit the numbers of the file, with no effect added.

    An unexplained gap displaces them only a little, because the weights include the model error that is left.

    Args:
        plain: the equations of the model as given, with the sensors' weights.
        start: the numbers as given.

    Returns:
        The fit; its hypothesis is within three tolerances, and its equations are those of the hypothesis.
    """
    at, here = plain.equations, start
    for _ in range(WEIGHTINGS):
        work = tempered(plain, error_of(plain, at.of(here.model()).residual))
        made = fit(here, work, steps=STEPS)
        here = made.hypothesis
    return within(made)


def within(made: Fit) -> Fit:
    """The fit with the numbers of the file limited to three tolerances; freed numbers stay as they are."""
    here = made.hypothesis.tolerated()
    if here.factors == made.hypothesis.factors:
        return made
    return dataclasses.replace(made, hypothesis=here, equations=made.equations.of(here.model()))
