"""What a diagnosis begins with: the equations of a model for its recordings, and the noise of their channels."""

from __future__ import annotations

import dataclasses

import numpy as np

from flexdyn.diagnose.data.channel_noise import encoder_noise, recorded_torque_noise
from flexdyn.diagnose.data.filters import SECOND_FILTER_WIDTHS, Filters
from flexdyn.diagnose.data.measured import Measured
from flexdyn.diagnose.equations.covariance import SampleNoise, encoders_rule, vibration_rules
from flexdyn.diagnose.equations.equations import Equations
from flexdyn.diagnose.hypothesis.estimate import fit
from flexdyn.diagnose.hypothesis.hypothesis import Hypothesis
from flexdyn.diagnose.hypothesis.unweighted import Unweighted
from flexdyn.diagnose.hypothesis.workspace import weighed
from flexdyn.errors import InputError, SimulationError
from flexdyn.model.flexible_joint_model import FlexibleJointModel
from flexdyn.model.uncertain_parameters import file_numbers, with_factors

PAUSES_STEPS = 3
"""Gauss-Newton steps of the file's numbers, by which the equations during pauses are chosen."""
MOST_SIMULATED = 100_000
"""Joints times samples, above which links are not simulated: some hundred fits of candidates simulate them again."""
MANY = 200.0
"""A wider filter is used only if recordings are longer than this multiple of it [1]."""


def prepared(
    model: FlexibleJointModel, data: tuple[Measured, ...], start: Hypothesis | None = None
) -> tuple[Unweighted, Hypothesis]:
    """Equations without weights, whose noise is as the recordings show it, and the numbers to start from.

    Raises:
        InputError: all rows are masked.
    """
    start = start or Hypothesis(model, dict.fromkeys(file_numbers(model), 1.0))
    noise = recorded_noise(data)
    bare = Unweighted.of(_filtered(with_factors(model, {}, start.effects), data, noise), noise, start.factors)
    used = ~bare.mask.reshape(-1, len(bare.equations.kinds))
    if used.sum(axis=0).min() < len(start.factors):  # sweeps of single joints: some equation cannot tell the numbers
        bare = _through_pauses(bare, start)
    if bare.mask.all():
        problem = "joints rest, or may rest, so often that no equation can be used"
        remedy = "let all joints move at once for seconds: while one sticks, its friction torque is unknown"
        raise InputError(problem, file=data[0].name, key="t", remedy=remedy)
    return bare, start


def _through_pauses(bare: Unweighted, start: Hypothesis) -> Unweighted:
    """Equations that use rows during pauses of motors: with simulated links, or with links that follow their load.

    Links are simulated unless a transmission has a torque sensor, whose rows know of no response, the record is too
    long, encoder noise would make the links vibrate too much, or the file's numbers, fitted, leave more with them: then
    the vibration is so far off that its slopes mislead.
    """
    following = Unweighted.of(
        dataclasses.replace(bare.equations, quasi_static=True, simulated=False), bare.noise, start.factors
    )
    moving = dataclasses.replace(bare.equations, quasi_static=False, simulated=True)
    size = moving.true.n * sum(len(each.t) for each in moving.data)
    if not moving.unmeasured.any() or moving.sensed or size > MOST_SIMULATED or vibration_rules(moving, bare.noise):
        return following
    behind = Unweighted.of(moving, bare.noise, start.factors)
    try:
        left = [fit(start, weighed(each), steps=PAUSES_STEPS).reduced for each in (behind, following)]
    except SimulationError:
        return following
    return behind if left[0] <= left[1] else following


def chosen_again(bare: Unweighted, there: Hypothesis) -> Unweighted:
    """Equations through pauses that suit what a fit has found; those that there are, if they suit it too.

    An effect that the file lacks may make the one kind or the other useless.

    Args:
        bare: the equations that were chosen at the file's numbers.
        there: the fitted hypothesis.
    """
    if not (bare.equations.quasi_static or bare.equations.simulated):
        return bare
    other = _through_pauses(bare, there)
    return bare if other.equations.simulated == bare.equations.simulated else other


def recorded_noise(data: tuple[Measured, ...]) -> SampleNoise:
    """Of the channels, as the record shows it."""
    torque = np.maximum(recorded_torque_noise(data), 1e-12)
    return SampleNoise(encoder_noise(data, "q"), encoder_noise(data, "theta"), torque, np.zeros(len(torque)))


def _filtered(model: FlexibleJointModel, data: tuple[Measured, ...], noise: SampleNoise) -> Equations:
    """The equations with the narrowest filter for which the encoders' noise is below that of the torque.

    If rows contain mainly noise times a number of the file, a smaller number would make them smaller.
    """
    found = Equations(model, data, Filters.of_rate(data[0].dt))
    for second in SECOND_FILTER_WIDTHS[1:]:
        short = min(len(each.t) for each in data) * data[0].dt < MANY * second
        if short or not encoders_rule(found, noise):
            break
        found = Equations(model, data, Filters.of_rate(data[0].dt, second=second))
    return found
