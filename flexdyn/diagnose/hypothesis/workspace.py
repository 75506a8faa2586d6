"""The common parts of all fits to the same data: equations, weights and priors."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from flexdyn.arrays import Array
from flexdyn.diagnose.equations.covariance import SampleNoise, Whitener, whitener
from flexdyn.diagnose.equations.equations import Equations
from flexdyn.diagnose.hypothesis.hypothesis import Hypothesis
from flexdyn.diagnose.hypothesis.unweighted import Unweighted
from flexdyn.diagnose.lazy import lazy
from flexdyn.effects import Effect


@dataclass(frozen=True, eq=False)
class Workspace:
    """The common parts of all fits to the same data.

    Attributes:
        bare: the equations of the given model and their slopes, without weights.
        whiten: of their rows.
        nuisance_sigma: standard deviations of what is fitted but not reported (k,).
        beliefs: prior of an effect's parameter: distance of its centre from the value, and its standard deviation.
        anew: the same with the weights of other equations; None: the weights do not change.
    """

    bare: Unweighted
    whiten: Whitener
    nuisance_sigma: Array
    beliefs: Callable[[Effect, str], tuple[float, float]] | None = None
    anew: Callable[[Equations], Workspace] | None = None

    @property
    def equations(self) -> Equations:
        """Of the given model."""
        return self.bare.equations

    @property
    def noise(self) -> SampleNoise:
        """Of the channels, which determines the weights."""
        return self.bare.noise

    @lazy
    def numbers(self) -> Array:
        """Whitened derivatives of the file's numbers (rows, numbers)."""
        return self.whiten(self.bare.numbers)

    @lazy
    def nuisance(self) -> Array:
        """Whitened columns of what is fitted but not reported (rows, k)."""
        return self.whiten(self.bare.unknown)

    def beside_nuisance(self, rows: Array) -> tuple[Array, Array]:
        """Whitened rows (rows, columns), and `nuisance`: one whitening of many columns takes as long as that of one."""
        white = self.whiten(np.column_stack([rows, self.bare.unknown]))
        first = white.shape[1] - self.bare.unknown.shape[1]
        return white[:, :first], white[:, first:]

    def with_equations(self, equations: Equations) -> Workspace:
        """Other equations with the same slopes and weights."""
        return dataclasses.replace(self, bare=dataclasses.replace(self.bare, equations=equations))

    def at(self, equations: Equations) -> Workspace:
        """The weights for other equations of the same data."""
        return self if self.anew is None else dataclasses.replace(self.anew(equations), beliefs=self.beliefs)

    def white(self, residual: Array) -> Array:
        """The whitened residual after the best offsets of the encoders are subtracted (rows,)."""
        return self.without_offsets(residual)[0]

    def without_offsets(self, residual: Array) -> tuple[Array, float]:
        """The same rows, and the sum of squares of these offsets over their standard deviations."""
        white, offsets, values = self._fitted_nuisances(residual)
        return np.asarray(white - offsets @ values), float(np.sum((values / self.nuisance_sigma) ** 2))

    def first_states(self, residual: Array) -> Array:
        """First states of simulated links in addition that fit a residual best (states,)."""
        return self._fitted_nuisances(residual)[2][self.bare.of_states]

    def calm(self, residual: Array) -> Array:
        """The residual, not whitened, without the vibration that first states of simulated links explain (rows,)."""
        by_states = self.bare.unknown[:, self.bare.of_states]
        return residual - by_states @ self.first_states(residual) if by_states.size else residual

    def _fitted_nuisances(self, residual: Array) -> tuple[Array, Array, Array]:
        """Whitened residual (rows,), whitened columns of what is not reported (rows, k), and their best values (k,)."""
        rows, offsets = self.beside_nuisance(residual)
        white, loose = rows[:, 0], np.diag(1.0 / self.nuisance_sigma**2)
        return white, offsets, np.asarray(np.linalg.solve(offsets.T @ offsets + loose, offsets.T @ white), dtype=float)

    @property
    def rows(self) -> int:
        """Number of rows that are not masked."""
        return int((~self.whiten.mask).sum())


def beginning_as(bare: Unweighted, there: Hypothesis) -> Unweighted:
    """The same equations whose simulated links begin as a hypothesis has it.

    Raises:
        SimulationError: the equations of the hypothesis are not finite.
    """
    if not bare.equations.simulated:
        return bare
    at = bare.equations.of(there.model())
    more = weighed(bare.with_offsets_of(at), at).first_states(at.residual)
    return Unweighted.of(bare.equations.beginning(more), bare.noise, there.factors)


def weighed(bare: Unweighted, at: Equations | None = None, extra: Array | None = None) -> Workspace:
    """Equations with weights from their noise.

    Args:
        bare: the equations to be fitted.
        at: equations of the hypothesis whose coefficients carry the noise; None: the given model's.
        extra: additional variance of the rows (rows,).
    """
    at = at if at is not None and at.noisy else bare.equations
    whiten, bare = whitener(at, bare.noise, bare.mask, extra), bare.with_first_states_of(at)
    levels = bare.noise.of_channels(bare.channels, bare.equations.true.joint_names)
    shapes = np.ones(bare.unknown.shape[1] - len(levels) - len(bare.states))
    return Workspace(bare, whiten, np.concatenate([2.0 * levels + 1e-12, bare.states, shapes]))
