"""Equations, weights and priors of a model for data, which all fits of a search share."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from flexdyn.arrays import Array, Flags
from flexdyn.diagnose.data.channel_noise import encoder_noise, recorded_torque_noise
from flexdyn.diagnose.data.filters import SECOND_FILTER_WIDTHS, Filters
from flexdyn.diagnose.data.measured import Measured
from flexdyn.diagnose.equations import columns
from flexdyn.diagnose.equations.covariance import SampleNoise, encoders_rule, vibration_rules, whitener
from flexdyn.diagnose.equations.equations import Equations
from flexdyn.diagnose.equations.hidden_links import of_first_states
from flexdyn.diagnose.equations.mask import sign_mask
from flexdyn.diagnose.equations.sensor_columns import of_hold_shape, of_lag_shape
from flexdyn.diagnose.hypothesis import number_columns
from flexdyn.diagnose.hypothesis.estimate import fit
from flexdyn.diagnose.hypothesis.fitted import Workspace
from flexdyn.diagnose.hypothesis.hypothesis import Hypothesis, count_of
from flexdyn.diagnose.lazy import kept
from flexdyn.effects import SensorEffect
from flexdyn.errors import InputError, SimulationError
from flexdyn.model.flexible_joint_model import FlexibleJointModel
from flexdyn.model.uncertain_parameters import FileNumber, file_numbers, with_factors

PAUSES_STEPS = 3
"""Gauss-Newton steps of the file's numbers, by which the equations during pauses are chosen."""
MOST_SIMULATED = 100_000
"""Joints times samples, above which links are not simulated: some hundred fits of candidates simulate them again."""
MANY = 200.0
"""A wider filter is used only if recordings are longer than this multiple of it [1]."""


@dataclass(frozen=True, eq=False)
class Unweighted:
    """Slopes of equations, without weights.

    Attributes:
        equations: that have the slopes.
        numbers: by the file's numbers (rows, numbers).
        offsets: by an offset of one count of each encoder, because rounding is unknown, by the first states of
            simulated links, and by the shapes of torques and of their lags (rows, channels + states + shapes).
        channels: of these encoders.
        states: standard deviations of these first states (states,).
        along: the equations along whose motion the slopes are; None: `equations`.
    """

    equations: Equations
    numbers: Array
    offsets: Array
    channels: tuple[str, ...]
    states: Array
    along: Equations | None = None

    @classmethod
    def of(cls, equations: Equations, numbers: Iterable[FileNumber], at: Equations | None = None) -> Unweighted:
        """Slopes by these numbers of the file; those by offsets at other equations, if given (`with_offsets_of`)."""
        channels = equations.data[0].encoders(equations.true.joint_names)
        states, sigma = of_first_states(equations)
        unknown = np.column_stack([*_of_offsets(at or equations, channels), states, *_of_shapes(at or equations)])
        return cls(equations, number_columns.of_numbers(equations, tuple(numbers)), unknown, channels, sigma)

    def with_offsets_of(self, at: Equations) -> Unweighted:
        """The same with the slopes of other equations by shapes of torques and by encoders' offsets.

        A spring that hardens feels an offset more. Without springs offsets act on gravity and inertia alone, which
        effects hardly change.
        """
        first = len(self.channels)
        offsets, states = list(self.offsets[:, :first].T), self.offsets[:, first : first + len(self.states)]
        if at.true.elastic.any():
            offsets = _of_offsets(at, self.channels)
        return dataclasses.replace(self, offsets=np.column_stack([*offsets, states, *_of_shapes(at)]))


@kept
def _of_offsets(equations: Equations, channels: tuple[str, ...]) -> list[Array]:
    return [columns.of_effect(equations, count_of(name, 1e-6), 1e-6) for name in channels]


def _of_shapes(equations: Equations) -> list[Array]:
    """Slopes by what no record says of torques: whether they were held, and whether a lag is a delay or a low pass."""
    errors = [each for each in equations.model.effects if isinstance(each, SensorEffect) and each.signal == "tau"]
    lags = [of_lag_shape(equations, each) for each in errors if each.lateness > 0.0]
    recorded = [j for j, laws in enumerate(equations.motors) if not laws and not equations.data[0].forced[j]]
    return [*(of_hold_shape(equations, j) for j in recorded), *lags]


def prepared(
    model: FlexibleJointModel, data: tuple[Measured, ...], start: Hypothesis | None = None
) -> tuple[Unweighted, SampleNoise, Hypothesis]:
    """Equations without weights, and the noise of their channels from the recordings.

    Raises:
        InputError: all rows are masked.
    """
    start = start or Hypothesis(model, dict.fromkeys(file_numbers(model), 1.0))
    noise = recorded_noise(data)
    bare = Unweighted.of(_filtered(with_factors(model, {}, start.effects), data, noise), start.factors)
    used = ~sign_mask(bare.equations, noise).reshape(-1, len(bare.equations.kinds))
    if used.sum(axis=0).min() < len(start.factors):  # sweeps of single joints: some equation cannot tell the numbers
        bare = _through_pauses(bare, noise, start)
    if sign_mask(bare.equations, noise).all():
        problem = "joints rest, or may rest, so often that no equation can be used"
        remedy = "let all joints move at once for seconds: while one sticks, its friction torque is unknown"
        raise InputError(problem, file=data[0].name, key="t", remedy=remedy)
    return bare, noise, start


def _through_pauses(bare: Unweighted, noise: SampleNoise, start: Hypothesis) -> Unweighted:
    """Equations that use rows during pauses of motors: with simulated links, or with links that follow their load.

    Links are simulated unless a transmission has a torque sensor, whose rows know of no response, the record is too
    long, encoder noise would make the links vibrate too much, or the file's numbers, fitted, leave more with them: then
    the vibration is so far off that its slopes mislead.
    """
    following = Unweighted.of(dataclasses.replace(bare.equations, quasi_static=True, simulated=False), start.factors)
    moving = dataclasses.replace(bare.equations, quasi_static=False, simulated=True)
    size = moving.true.n * sum(len(each.t) for each in moving.data)
    if not moving.unmeasured.any() or moving.sensed or size > MOST_SIMULATED or vibration_rules(moving, noise):
        return following
    behind = Unweighted.of(moving, start.factors)
    try:
        left = [fit(start, weighed(each, noise), steps=PAUSES_STEPS).reduced for each in (behind, following)]
    except SimulationError:
        return following
    return behind if left[0] <= left[1] else following


def chosen_again(bare: Unweighted, noise: SampleNoise, there: Hypothesis) -> Unweighted:
    """Equations through pauses that suit what a fit has found; those that there are, if they suit it too.

    An effect that the file lacks may make the one kind or the other useless.

    Args:
        bare: the equations that were chosen at the file's numbers.
        noise: of the channels.
        there: the fitted hypothesis.
    """
    if not (bare.equations.quasi_static or bare.equations.simulated):
        return bare
    other = _through_pauses(bare, noise, there)
    return bare if other.equations.simulated == bare.equations.simulated else other


def recorded_noise(data: tuple[Measured, ...]) -> SampleNoise:
    """Of the channels, as the record shows it."""
    torque = np.maximum(recorded_torque_noise(data), 1e-12)
    return SampleNoise(encoder_noise(data, "q"), encoder_noise(data, "theta"), torque, np.zeros(len(torque)))


def weighed(
    bare: Unweighted,
    noise: SampleNoise,
    mask: Flags | None = None,
    extra: Array | None = None,
    at: Equations | None = None,
) -> Workspace:
    """Equations with weights from the noise.

    Args:
        bare: slopes of the equations to be fitted.
        noise: of the channels.
        mask: rows that are not used; None: determined from the noise.
        extra: additional variance of the rows (rows,).
        at: equations of the hypothesis whose coefficients carry the noise; None: the given model's.
    """
    equations = bare.equations
    mask = sign_mask(equations, noise) if mask is None else mask
    whiten = whitener(at if at is not None and at.noisy else equations, noise, mask, extra)
    levels = noise.of_channels(bare.channels, equations.true.joint_names)
    shapes = np.ones(bare.offsets.shape[1] - len(levels) - len(bare.states))
    sigma = np.concatenate([2.0 * levels + 1e-12, bare.states, shapes])
    return Workspace(equations, whiten, noise, bare.numbers, bare.offsets, sigma, bare.channels, along=bare.along)


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
