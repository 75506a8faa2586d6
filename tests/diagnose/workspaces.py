"""Equations, weights and priors of a model over data, weighed by a fit of the model as it was given."""

from __future__ import annotations

import dataclasses

from flexdyn.diagnose.data.measured import Measured
from flexdyn.diagnose.equations.covariance import SampleNoise
from flexdyn.diagnose.equations.noise import torque_noise
from flexdyn.diagnose.hypothesis.estimate import fit
from flexdyn.diagnose.hypothesis.hypothesis import Hypothesis
from flexdyn.diagnose.hypothesis.prepared import prepared
from flexdyn.diagnose.hypothesis.workspace import Workspace, weighed
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
    bare, start = prepared(model, data, start)
    space = weighed(bare)
    for _ in range(2):
        made = fit(start, space, steps=3)
        tau = torque_noise(made.equations, made.equations.residual, bare.mask, bare.noise)
        bare = dataclasses.replace(bare, noise=dataclasses.replace(bare.noise, tau=tau))
        space = weighed(bare)
    return space, start, bare.noise
