"""Best first states of the windows, from linear responses to noise and to the states themselves."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass

import numpy as np

from flexdyn.arrays import Array, Flags
from flexdyn.diagnose.shooting.shooter import Shooter, SimulatedWindows
from flexdyn.diagnose.shooting.spread import spread
from flexdyn.diagnose.shooting.starts import Starts
from flexdyn.diagnose.shooting.whiten import Filter

LARGEST_FIRST_STATE_SHIFT = 100.0
"""Largest change of a first state, in standard deviations [1]: a larger one comes from a divergent response."""
FAILED_WINDOW_SHARE = 0.3
"""A law is rejected if more than this share of windows cannot be simulated, or if noise covers any error there [1]."""
CORRECTION_ROUNDS = 6
"""Largest number of corrections of the first states, each with a new linear response."""
WORTHWHILE_REMAINDER = 0.8
"""Another correction is made if the last one reduced the squared residual below this share [1]."""
STRAY_WINDOW_RATIO = 4.0
"""A window with a gap above this multiple of the median may have wrong sticking: it is corrected further [1]."""
SHORTENED_CORRECTION = 0.3
"""A correction that increased the residual is tried again with this share of its length [1]."""
FAILED_SAMPLE_ERROR = 3.0
"""Error of a sample that the simulation did not reach, as a multiple of its channel's range (plus 1 rad) [1]."""


@dataclass(frozen=True, eq=False)
class Matched:
    """Windows from their best first states.

    Attributes:
        moved: changes of the first states from their prior means (windows, nx).
        residual: simulated - measured (windows, rows, channels).
        motion: that was simulated.
        filter: Kalman filter that whitens the residual.
    """

    moved: Array
    residual: Array
    motion: SimulatedWindows
    filter: Filter

    def stray(self, used: Flags) -> Flags:
        """Windows with much larger residuals than the others (windows,)."""
        size = self.filter.scaled(self.residual)
        return np.asarray(size > STRAY_WINDOW_RATIO**2 * max(float(np.median(size)), float(used[0].sum())))

    def is_noise(self, used: Flags) -> bool:
        """Whether the median window is of the size of noise."""
        size = float(np.median(self.filter.scaled(self.residual)))
        return size <= STRAY_WINDOW_RATIO * float(used[0].sum())


@dataclass(frozen=True, eq=False)
class Matching:
    """The search for the best first states of windows.

    Attributes:
        shooter: of the model and the windows.
        starts: prior means and widths of the first states.
        used: samples that count (windows, rows, channels).
    """

    shooter: Shooter
    starts: Starts
    used: Flags

    def best(self, near: Array | None = None) -> Matched:
        """Correct first states until the residual hardly decreases.

        Windows with large residuals are tried again with unmeasured joints at rest, where friction may hold them, and
        from the first states of a similar model. If they are a few among windows that leave noise, other deflections of
        joints with one encoder are tried as well.

        Args:
            near: best first states of a similar model (windows, nx); None: there is none.
        """
        means = self.starts.x
        found = self._from(np.zeros_like(means))
        for other in (self.starts.stuck, near):
            stray = found.stray(self.used)
            if other is None or other.shape != means.shape or not stray.any():
                continue
            found = self._tried(found, other - means, stray)
        for other in self.starts.deflected:
            stray = found.stray(self.used)
            if not stray.any() or not found.is_noise(self.used):
                break
            found = self._tried(found, other - means, stray)
        return found

    def _tried(self, found: Matched, moved: Array, some: Flags) -> Matched:
        """Some windows from other first states, if these are better."""
        begin = np.where(some[:, None], self._within(moved), found.moved)
        return self._better(found, self._from(begin, found, some))

    def _within(self, moved: Array) -> Array:
        """Limit changes (windows, nx) to their largest allowed size."""
        most = LARGEST_FIRST_STATE_SHIFT * np.sqrt(np.diagonal(self.starts.prior, axis1=1, axis2=2))
        return np.clip(np.nan_to_num(moved), -most, most)

    def _from(self, moved: Array, rest: Matched | None = None, some: Flags | None = None) -> Matched:
        """Correct the first states by linear responses until the residual hardly decreases.

        Args:
            moved: first changes (windows, nx).
            rest: present result, of which only some windows are corrected; None: all of them.
            some: windows to correct (windows,).
        """
        shooter, means = self.shooter, self.starts.x
        some = np.ones(len(moved), bool) if some is None else some
        motion = shooter.run(means + moved, which=np.flatnonzero(some), others=None if rest is None else rest.motion)
        residual = bounded_residual(shooter, motion, self.used)
        fit = Matched(moved, residual, motion, self._filter(motion, some, rest))
        factor, active = np.ones(len(moved)), some
        if np.mean(motion.written < shooter.windows.rows) > FAILED_WINDOW_SHARE:
            return fit
        for _ in range(CORRECTION_ROUNDS):
            wanted = fit.moved - factor[:, None] * fit.filter.first_error(fit.residual, fit.moved)
            wanted = shooter.bounded(means + self._within(wanted)) - means
            again = shooter.run(means + wanted, which=np.flatnonzero(active), others=fit.motion)
            left = bounded_residual(shooter, again, self.used)
            before, after = (fit.filter.scaled(each) for each in (fit.residual, left))
            better = active & (after < before)
            factor = np.where(better, 1.0, SHORTENED_CORRECTION * factor)
            motion = fit.motion.replaced(better, again.part(better))
            moved = np.where(better[:, None], wanted, fit.moved)
            fit = Matched(moved, np.where(better[:, None, None], left, fit.residual), motion, fit.filter)
            stray = some & fit.stray(self.used)
            if np.minimum(before, after)[some].sum() > WORTHWHILE_REMAINDER * before[some].sum() and not stray.any():
                break
            active = active & (np.abs(before - after) > (1.0 - WORTHWHILE_REMAINDER) * before) | stray
            fit = dataclasses.replace(fit, filter=self._filter(motion, better, fit))
        return fit

    def _filter(self, motion: SimulatedWindows, some: Flags, rest: Matched | None) -> Filter:
        """The filter of a motion: computed again for some windows, unchanged for the others."""
        which = np.flatnonzero(some)
        if rest is not None and not len(which):
            return rest.filter
        made = Filter.of(self.shooter.windows, spread(self.shooter, motion, which), self.starts.prior, self.used, which)
        return made if rest is None else rest.filter.replaced(which, made)

    def _better(self, one: Matched, other: Matched) -> Matched:
        """For each window the fit with the smaller residual."""
        wins = other.filter.scaled(other.residual) < one.filter.scaled(one.residual)
        motion = one.motion.replaced(wins, other.motion.part(wins))
        moved = np.where(wins[:, None], other.moved, one.moved)
        residual = np.where(wins[:, None, None], other.residual, one.residual)
        return Matched(moved, residual, motion, self._filter(motion, wins, one))


def bounded_residual(shooter: Shooter, motion: SimulatedWindows, used: Flags) -> Array:
    """Simulated - measured, bounded, also if the simulation failed."""
    windows = shooter.windows
    limit = 1.0 + FAILED_SAMPLE_ERROR * windows.span
    with np.errstate(invalid="ignore", over="ignore"):
        difference = shooter.reported(motion) - shooter.measured
    reached = np.arange(windows.rows) < motion.written[:, None]
    difference = np.where(reached[:, :, None] & np.isfinite(difference), difference, limit)
    return np.where(used & np.isfinite(shooter.measured), np.clip(difference, -limit, limit), 0.0)
