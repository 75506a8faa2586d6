"""Where a joint may stick: the sign of its velocity is uncertain, so that dry friction can have any value."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from flexdyn.arrays import Array, Flags
from flexdyn.diagnose.constants import CERTAIN_SIGMAS
from flexdyn.diagnose.data.channel_noise import encoder_noise
from flexdyn.diagnose.data.filters import Filters
from flexdyn.diagnose.data.measured import Measured
from flexdyn.records.signals.kernels import GaussianSmoother


@dataclass(frozen=True, eq=False)
class Rests:
    """Where motors rest whose links are not measured.

    Attributes:
        where: (samples after the first filter, n).
        filters: of the equations; the second one takes the encoders' noise off the load of a resting joint.
    """

    where: Flags
    filters: Filters

    @classmethod
    def of(cls, data: Measured, filters: Filters) -> Rests:
        """Pauses of motors that are longer than what a row covers."""
        first = filters.first
        where = np.zeros((len(data.t) - 2 * first.half, len(data.has_q)), dtype=bool)
        noise = encoder_noise((data,), "theta")
        for j in np.flatnonzero(data.has_theta & ~data.has_q & ~data.forced).tolist():
            uncertain = uncertain_sign(first.apply(data.theta[:, j], 1), noise[j], first)
            where[:, j] = long_runs(uncertain, 2 * filters.reach(2))
        return cls(where, filters)

    @classmethod
    def everywhere(cls, data: Measured, filters: Filters) -> Rests:
        """As if all these motors rested all the time: no torque of theirs tells where their links are."""
        samples = len(data.t) - 2 * filters.first.half
        return cls(np.tile(data.has_theta & ~data.has_q & ~data.forced, (samples, 1)), filters)

    def instead(self, j: int, load: Array, other: Array) -> Array:
        """The smoothed load of a joint where it rests, else another signal (samples,)."""
        return np.where(self.where[:, j], self.filters.calmed(load), other) if self.where[:, j].any() else other


def uncertain_sign(u: Array, sigma: float, kernel: GaussianSmoother) -> Flags:
    """Samples (samples,) at which a filtered velocity may have either sign.

    Args:
        u: the velocity (samples,) [rad/s or m/s].
        sigma: standard deviation of the encoder [rad or m].
        kernel: filter that made the velocity from the position.
    """
    spread = float(np.linalg.norm(kernel.taps[1]))
    uncertain = np.abs(u) <= CERTAIN_SIGMAS * spread * sigma  # the sign of 0 is always uncertain
    uncertain[1:] |= u[1:] * u[:-1] < 0.0
    return np.asarray(uncertain)


def touches_zero(u: Array, kernel: GaussianSmoother) -> Flags:
    """Samples (samples,) at which a filtered velocity may have been zero for a moment.

    It keeps its sign in the mean over the filter, but it bends: where it touches zero with the acceleration a, a filter
    of the width w makes ``u = sqrt(2/pi) a w`` and ``u'' = u/w^2`` of it. So ``u`` and ``u - 2 w^2 u''`` have different
    signs there; a filter that is applied twice has the variance ``2 w^2``.

    Args:
        u: the velocity (samples,) [rad/s or m/s].
        kernel: filter that made the velocity from the position.
    """
    bent = np.zeros(len(u), dtype=bool)
    bent[1:-1] = u[1:-1] * (u[1:-1] - 2.0 * kernel.variance * np.diff(u, 2)) <= 0.0
    return bent


def near(samples: Flags, reach: int) -> Flags:
    """Samples (samples,) that are at most `reach` from one of some samples."""
    return np.asarray(np.convolve(samples, np.ones(2 * reach + 1), "same") > 0.5)


def long_runs(samples: Flags, length: int) -> Flags:
    """Those of some samples (samples,) that stand in a run of more than so many."""
    from scipy.ndimage import binary_opening

    return np.asarray(binary_opening(samples, np.ones(length + 1)))


def borders(samples: Flags) -> Flags:
    """Samples (samples,) on both sides of each place where a run of some samples begins or ends."""
    change = np.diff(samples)
    return np.asarray(np.pad(change, (1, 0)) | np.pad(change, (0, 1)))
