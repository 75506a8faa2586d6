"""What a diagnosis begins with: the equations of a model for its recordings, and the noise of their channels."""

from __future__ import annotations

import dataclasses

import numpy as np

from flexdyn.diagnose.data.channel_noise import encoder_noise, recorded_torque_noise
from flexdyn.diagnose.data.filters import SECOND_FILTER_WIDTHS, Filters
from flexdyn.diagnose.data.measured import Measured
from flexdyn.diagnose.equations.covariance import SampleNoise, encoders_rule, vibration_rules
from flexdyn.diagnose.equations.equations import Equations
from flexdyn.diagnose.equations.mask import reversal_mask
from flexdyn.diagnose.hypothesis.hypothesis import Hypothesis
from flexdyn.diagnose.hypothesis.unweighted import Unweighted
from flexdyn.errors import InputError
from flexdyn.model.flexible_joint_model import FlexibleJointModel
from flexdyn.model.uncertain_parameters import file_numbers, with_factors

MOST_SIMULATED = 100_000
"""Joints times samples, above which links are not simulated: some hundred fits of candidates simulate them again."""
MANY = 200.0
"""A wider filter is used only if recordings are longer than this multiple of it [1]."""


def prepared(
    model: FlexibleJointModel, data: tuple[Measured, ...], start: Hypothesis | None = None
) -> tuple[Unweighted, Hypothesis]:
    """Equations without weights, whose noise is as the recordings show it, and the numbers to start from.

    The position of a link that is not measured is computed from its motor's torque. Where too few rows are left while
    motors move, links follow their load during pauses; where none are left even so, links are simulated.

    Raises:
        InputError: all rows are masked.
    """
    start = start or Hypothesis(model, dict.fromkeys(file_numbers(model), 1.0))
    noise, given = recorded_noise(data), with_factors(model, {}, start.effects)
    moving = _filtered(Equations(given, between_counts(data), Filters.of_rate(data[0].dt)), noise)
    bare = Unweighted.of(moving, noise, start.factors)
    used = ~bare.mask.reshape(-1, len(moving.kinds))
    if used.sum(axis=0).min() < len(start.factors):  # sweeps of single joints: some equation cannot tell the numbers
        bare = Unweighted.of(dataclasses.replace(moving, quasi_static=True), noise, start.factors)
    if bare.mask.all():
        bare = behind_motors(bare, start) or bare
    if bare.mask.all():
        problem = "joints rest, or may rest, so often that no equation can be used"
        remedy = "let all joints move at once for seconds: while one sticks, its friction torque is unknown"
        raise InputError(problem, file=data[0].name, key="t", remedy=remedy)
    return bare, start


def without_reversals(bare: Unweighted) -> Unweighted | None:
    """Equations without the rows in which the load of a link that is not measured may change its sign.

    They see nothing of a play in its gear, and all that they see is right whether there is one or not.

    Args:
        bare: equations in which the positions of these links are computed.

    Returns:
        None where all links are measured, or no row is left.
    """
    if not bare.equations.unmeasured.any() or bare.equations.simulated:
        return None
    mask = bare.mask | reversal_mask(bare.equations, bare.noise)
    return None if mask.all() else dataclasses.replace(bare, mask=mask)


def behind_motors(bare: Unweighted, start: Hypothesis) -> Unweighted | None:
    """Equations in which the links that are not measured are simulated behind their motors, as these moved.

    They use more rows, behind a narrower filter: the position of a link that is computed from its motor's torque has
    this torque's noise and, while the motor sticks, its unknown friction.

    Args:
        bare: equations in which the positions of these links are computed.
        start: the file's numbers.

    Returns:
        None where all links are measured, a transmission has a torque sensor, whose rows know of no response, the
        record is too long, or encoder noise would make the links vibrate too much.
    """
    equations = bare.equations
    size = equations.true.n * sum(len(each.t) for each in equations.motions)
    if not equations.unmeasured.any() or equations.sensed or size > MOST_SIMULATED or equations.simulated:
        return None
    narrow = Filters.of_rate(equations.data[0].dt)
    moving = dataclasses.replace(equations, filters=narrow, quasi_static=False, simulated=True)
    moving = _filtered(moving, bare.noise)
    return None if vibration_rules(moving, bare.noise) else Unweighted.of(moving, bare.noise, start.factors)


def between_counts(data: tuple[Measured, ...]) -> tuple[Measured, ...]:
    """Recordings with positions between the counts of encoders whose increments stay equal.

    For longer than the narrowest filters reach: all equations of the same recordings have the same positions.
    """
    return tuple(each.between_steps(2 * Filters.of_rate(each.dt).reach(1)) for each in data)


def recorded_noise(data: tuple[Measured, ...]) -> SampleNoise:
    """Of the channels, as the record shows it."""
    torque = np.maximum(recorded_torque_noise(data), 1e-12)
    return SampleNoise(encoder_noise(data, "q"), encoder_noise(data, "theta"), torque, np.zeros(len(torque)))


def _filtered(found: Equations, noise: SampleNoise) -> Equations:
    """The equations with the narrowest filter for which the encoders' noise is below that of the torque.

    If rows contain mainly noise times a number of the file, a smaller number would make them smaller.
    """
    for second in SECOND_FILTER_WIDTHS[1:]:
        dt = found.data[0].dt
        short = min(len(each.t) for each in found.data) * dt < MANY * second
        if short or not encoders_rule(found, noise):
            break
        found = dataclasses.replace(found, filters=Filters.of_rate(dt, second=second))
    return found
