"""Equations with their slopes, before they are weighted, and what their weights follow from."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from flexdyn.arrays import Array, Flags
from flexdyn.diagnose.equations import columns
from flexdyn.diagnose.equations.covariance import SampleNoise
from flexdyn.diagnose.equations.equations import Equations
from flexdyn.diagnose.equations.hidden_links import of_first_states
from flexdyn.diagnose.equations.mask import sign_mask
from flexdyn.diagnose.equations.sensor_columns import of_hold_shape, of_lag_shape
from flexdyn.diagnose.hypothesis import number_columns
from flexdyn.diagnose.hypothesis.hypothesis import count_of
from flexdyn.diagnose.lazy import kept
from flexdyn.effects import SensorEffect
from flexdyn.model.uncertain_parameters import FileNumber


@dataclass(frozen=True, eq=False)
class Unweighted:
    """Equations with their slopes, without weights.

    Attributes:
        equations: that have the slopes.
        noise: of the channels.
        mask: rows that are not used (rows,).
        channels: of the encoders, each with an unknown offset.
        numbers: slopes by the file's numbers (rows, numbers).
        unknown: slopes by what is fitted but not reported: an offset of one count of each encoder, because rounding is
            unknown, the first states of simulated links, and the shapes of torques and of their lags (rows, channels +
            states + shapes).
        states: standard deviations of these first states (states,).
        along: the equations along whose motion the slopes are; None: `equations`.
    """

    equations: Equations
    noise: SampleNoise
    mask: Flags
    channels: tuple[str, ...]
    numbers: Array
    unknown: Array
    states: Array
    along: Equations | None = None

    @property
    def of_states(self) -> slice:
        """Columns of `unknown` that are of first states."""
        return slice(len(self.channels), len(self.channels) + len(self.states))

    @classmethod
    def of(cls, equations: Equations, noise: SampleNoise, numbers: Iterable[FileNumber]) -> Unweighted:
        """Slopes by these numbers of the file; rows are masked where the noise says so."""
        channels = equations.data[0].encoders(equations.true.joint_names)
        slopes = _slopes_by_all(equations, numbers, equations, channels)
        return cls(equations, noise, sign_mask(equations, noise), channels, *slopes)

    def with_slopes_along(self, along: Equations, numbers: Iterable[FileNumber], at: Equations) -> Unweighted:
        """The same equations with slopes along another motion; those by offsets at other equations along it."""
        by_numbers, unknown, states = _slopes_by_all(along, numbers, at, self.channels)
        return dataclasses.replace(self, numbers=by_numbers, unknown=unknown, states=states, along=along)

    def sloping(self, at: Equations) -> Equations:
        """Those along whose motion the slopes of a hypothesis are, whose own equations are given."""
        return at if self.along is None else self.along.of(at.model)

    def with_offsets_of(self, at: Equations) -> Unweighted:
        """The same with the slopes of other equations by all that is not reported.

        A spring that hardens feels an offset more. Without springs offsets act on gravity and inertia alone, which
        effects hardly change.
        """
        offsets, states = list(self.unknown[:, : len(self.channels)].T), self.unknown[:, self.of_states]
        if at.true.elastic.any():
            offsets = _of_offsets(at, self.channels)
        return dataclasses.replace(self, unknown=np.column_stack([*offsets, states, *_of_shapes(at)]))

    def with_first_states_of(self, at: Equations) -> Unweighted:
        """The same with the slopes of other equations by first states of links that are simulated.

        After many periods of a vibration a small change of its frequency is another phase.
        """
        if not at.simulated:
            return self
        states, sigma = of_first_states(at)
        unknown = self.unknown.copy()
        unknown[:, self.of_states] = states
        return dataclasses.replace(self, unknown=unknown, states=sigma)


def _slopes_by_all(
    equations: Equations, numbers: Iterable[FileNumber], at: Equations, channels: tuple[str, ...]
) -> tuple[Array, Array, Array]:
    """Slopes by the file's numbers and by what is not reported, and standard deviations of first states."""
    states, sigma = of_first_states(at)
    unknown = np.column_stack([*_of_offsets(at, channels), states, *_of_shapes(at)])
    return number_columns.of_numbers(equations, tuple(numbers)), unknown, sigma


@kept
def _of_offsets(equations: Equations, channels: tuple[str, ...]) -> list[Array]:
    return [columns.of_effect(equations, count_of(name, 1e-6), 1e-6) for name in channels]


def _of_shapes(equations: Equations) -> list[Array]:
    """Slopes by what no record says of torques: whether they were held, and whether a lag is a delay or a low pass."""
    errors = [each for each in equations.model.effects if isinstance(each, SensorEffect) and each.signal == "tau"]
    lags = [of_lag_shape(equations, each) for each in errors if each.lateness > 0.0]
    recorded = [j for j, laws in enumerate(equations.motors) if not laws and not equations.data[0].forced[j]]
    return [*(of_hold_shape(equations, j) for j in recorded), *lags]
