"""Equations, weights and priors of a model over data, weighed by a fit of the model as it was given."""

from __future__ import annotations

import dataclasses

from flexdyn.diagnose.data.measured import Measured
from flexdyn.diagnose.equations.covariance import SampleNoise
from flexdyn.diagnose.equations.noise import torque_noise
from flexdyn.diagnose.hypothesis.estimate import fit
from flexdyn.diagnose.hypothesis.fitted import Workspace
from flexdyn.diagnose.hypothesis.hypothesis import Hypothesis
from flexdyn.diagnose.hypothesis.workspace import prepared, weighed
from flexdyn.model.flexible_joint_model import FlexibleJointModel


def workspace(
    model: FlexibleJointModel, data: tuple[Measured, ...], start: Hypothesis | None = None
) -> tuple[Workspace, Hypothesis, SampleNoise]:
    """Equations, weights and priors of a model over data; the torque's noise comes from what a first fit leaves.

    Args:
        model: as it was given.
        data: to be explained.
        start: with the effects that were found, where one of them changes which equations there are; None: the model.

    Raises:
        InputError: no equation says anything at any time.
    """
    bare, noise, start = prepared(model, data, start)
    space = weighed(bare, noise)
    for _ in range(2):
        made = fit(start, space, steps=3)
        left, mask = made.equations.residual, space.whiten.mask
        noise = dataclasses.replace(noise, tau=torque_noise(made.equations, left, mask, noise))
        space = weighed(bare, noise, mask)
    return space, start, noise
