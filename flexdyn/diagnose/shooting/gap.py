"""The gap: errors of simulated positions over windows, divided by the values that noise alone would give."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from flexdyn.arrays import Array, Flags
from flexdyn.diagnose.constants import CERTAIN_SIGMAS, NOISE_GAP, NOISE_LEVEL_ERROR, STRAY_SHARE
from flexdyn.diagnose.equations.shared import same_signals
from flexdyn.diagnose.shooting.matched import FAILED_WINDOW_SHARE, Matching, bounded_residual
from flexdyn.diagnose.shooting.shooter import Shooter
from flexdyn.diagnose.shooting.starts import window_starts
from flexdyn.diagnose.shooting.whiten import Filter
from flexdyn.diagnose.shooting.windows import Windows
from flexdyn.model.flexible_joint_model import FlexibleJointModel

FRAGILE_RATIO = 3.0
"""A window is fragile if drawn noise has a larger effect than this multiple of the linear response [1]."""


@dataclass(frozen=True, eq=False)
class Shot:
    """A model simulated over windows, each from its best first state.

    The first state of a window is a nuisance parameter with a wide Gaussian prior. Let S be its sensitivities, P its
    prior covariance, G Q G^T the torque noise carried through the simulation and R the sensors' noise. Then the
    residual r at the prior mean has the covariance C = R + G Q G^T + S P S^T. The first state is changed by P S^T C^-1
    r and the window is simulated again. The remaining residual has the covariance R + G Q G^T - S P+ S^T, P+ = P - P
    S^T C^-1 S P; `std` is the root of its diagonal.

    Attributes:
        model: that was simulated.
        windows: that were simulated.
        x0: first states (windows, nx).
        residual: simulated - measured (windows, rows, channels), 0 where nothing was measured.
        std: its standard deviation from noise alone, likewise.
        used: samples that count, likewise.
        fragile: factor on `std` of windows in which drawn noise has a larger effect than in the linear response,
            because it decides whether a joint sticks (windows,) [1].
        failed: windows that could not be simulated to their end, or in which the noise covers any error (windows,).
    """

    model: FlexibleJointModel
    windows: Windows
    x0: Array
    residual: Array
    std: Array
    used: Flags
    fragile: Array
    failed: Flags
    _filter: Filter
    _moved: Array

    @property
    def scaled(self) -> Array:
        """Residual in units of noise (windows, rows, channels)."""
        return self.residual / self.std

    @property
    def gap(self) -> float:
        """Root mean square of `scaled` over all measured samples [1]."""
        return float(np.sqrt((self.scaled[self.used] ** 2).mean()))

    @property
    def by_window(self) -> Array:
        """The gap of every window (windows,) [1]."""
        count = np.maximum(self.used.sum(axis=(1, 2)), 1)
        return np.asarray(np.sqrt((self.scaled**2 * self.used).sum(axis=(1, 2)) / count))

    def whitened(self, model: FlexibleJointModel | None = None) -> Array:
        """Whitened residuals: uncorrelated with unit variance if the model is right (windows, rows of each).

        Samples are averaged over blocks; rows are the innovations of a Kalman filter on the linear response, divided
        by their standard deviations. The sum of squares is r^T C^-1 r, linear in r.

        Args:
            model: another model, simulated from the same first states with the same weights; None: this model.
                Differences of such residuals over a step of a parameter give the Jacobian for Gauss-Newton.
        """
        residual = self.residual if model is None else self.residual_of(model)
        return self._filter.whitened(residual, self._moved) / self.fragile[:, None]

    def whitened_change(self, change: Array) -> Array:
        """What a change of the residual changes in `whitened` (windows, rows of each).

        Args:
            change: as of `residual_of` of another model (windows, rows, channels).
        """
        return self._filter.whitened(change, np.zeros_like(self._moved)) / self.fragile[:, None]

    def is_noise(self) -> bool:
        """Whether the gap of the median window is noise; a single window with wrong sticking has little influence."""
        return float(np.median(self.by_window)) <= NOISE_GAP

    @property
    def misfit(self) -> Array:
        """Mean square of the innovations of every window (windows,) [1]: 1 if the model is right."""
        white = self._filter.whitened(self.residual, self._moved)
        return np.asarray((white**2).sum(axis=1) / np.maximum(self._rows, 1.0))

    @property
    def log_likelihood(self) -> float:
        """Log likelihood of the model, with the most likely size of the error beyond noise in each window.

        With N innovations, their mean square v and covariance C, a window adds ``- N l(v) - log|C|/2`` with ``l(v) = (1
        + log v)/2`` if v > 1, else ``v/2``: a single window with wrong sticking does not dominate the others.
        """
        v = self.misfit
        each = np.where(v > 1.0, 0.5 * (1.0 + np.log(np.maximum(v, 1.0))), 0.5 * v)
        return float(-(self._rows * each).sum() - 0.5 * self._filter.log_determinant.sum())

    @property
    def above_noise(self) -> float:
        """Log likelihood that the windows would gain if no error beyond noise were left [1]."""
        return float((self._rows * 0.5 * np.log(np.maximum(self.misfit, 1.0))).sum())

    @property
    def left(self) -> float:
        """Mean square of `scaled` over all windows but those that are farthest off [1]: 1 if the model is right.

        Noise decides when a joint sticks. No linear response covers that, so a few windows of a perfect model are far
        off (a trimmed mean).
        """
        each = np.sort(self.by_window**2)
        return float(each[: max(1, math.ceil((1.0 - STRAY_SHARE) * len(each)))].mean())

    def has_white_innovations(self) -> bool:
        """Whether the innovations are noise, chance and a misjudged level of it, in all windows but a few.

        The noise that builds up over a window hides errors from `left`, but not from them.
        """
        kept = np.argsort(self.misfit)[: math.ceil((1.0 - STRAY_SHARE) * len(self.misfit))]
        rows, misfit = self._rows[kept], self.misfit[kept]
        count = max(float(rows.sum()), 1.0)
        chance = CERTAIN_SIGMAS * math.sqrt(2.0 / count)
        return float((rows * misfit).sum()) <= (1.0 + NOISE_LEVEL_ERROR + chance) * count

    def is_mostly_noise(self, floor: float = 1.0) -> bool:
        """Whether all windows but those that are farthest off are noise together.

        Args:
            floor: the gap of a perfect model, if it is more than 1.
        """
        return self.left <= (NOISE_GAP * max(floor, 1.0)) ** 2

    @property
    def _rows(self) -> Array:
        """Innovations of every window (windows,)."""
        return np.asarray(self._filter.counted.sum(axis=(1, 2)))

    def residual_of(self, model: FlexibleJointModel) -> Array:
        """Simulated - measured for another model with the same first states (windows, rows, channels).

        If its sensors differ, so do the states that they measure at a window's start: by as much as the prior means.
        """
        shooter = Shooter(model, self.windows)
        x0 = _fitting(self.x0, self.model, shooter)
        if x0.shape == self._moved.shape and not same_signals(self.model, model):
            x0 = shooter.bounded(window_starts(shooter).x + self._moved)
        return bounded_residual(shooter, shooter.run(x0), self.used)

    def floor(self) -> float:
        """The gap of a perfect model: torques and sensors with drawn noise, simulated by the model itself."""
        shooter, used = Shooter(self.model, self.windows), self.used
        residual = _drawn(shooter, self.x0, self.residual, used, seed=1)
        wanted = -self._filter.first_error(residual, np.zeros_like(self._moved))
        left = (
            residual + bounded_residual(shooter, shooter.run(shooter.bounded(self.x0 + wanted)), used) - self.residual
        )
        better = self._filter.scaled(left) < self._filter.scaled(residual)
        residual[better] = left[better]
        return float(np.sqrt(((residual / self.std)[used] ** 2).mean()))


def shoot(model: FlexibleJointModel, windows: Windows, near: Array | None = None) -> Shot:
    """Simulate every window in open loop and find its best first state.

    A window that cannot be simulated to its end has a bounded residual: three times the range of the channel in the
    recordings plus 1 rad, for every sample that was not reached or has a larger error.

    Args:
        model: with any effects; those of sensors act on the simulated signals before the comparison.
        windows: with noise levels.
        near: best first states of a similar model (windows, nx), for windows with large residuals.
    """
    shooter = Shooter(model, windows)
    starts = window_starts(shooter)
    used = _used(shooter)
    fit = Matching(shooter, starts, used).best(near)
    x0, moved, residual, motion, filter_ = starts.x + fit.moved, fit.moved, fit.residual, fit.motion, fit.filter
    std = np.repeat(np.sqrt(filter_.variance), windows.block, axis=1)
    failed = motion.written < windows.rows
    if filter_.wild.mean() > FAILED_WINDOW_SHARE:  # without a finite response the noise covers no error
        failed |= filter_.wild
    drawn = _drawn(shooter, x0, residual, used, seed=0)
    expected = np.repeat(filter_.unfitted, windows.block, axis=1)
    size = np.sqrt((drawn**2 / expected).sum(axis=(1, 2)) / np.maximum(used.sum(axis=(1, 2)), 1))
    fragile = np.where((size > FRAGILE_RATIO) & ~failed, size, 1.0)
    std *= fragile[:, None, None]
    std[failed] = windows.sensor_noise
    return Shot(model, windows, x0, residual, std, used, fragile, failed, filter_, moved)


def _used(shooter: Shooter) -> Flags:
    """Measured samples, in whole blocks.

    A window that needs torques from before the recording does not count, unless there is no other.
    """
    windows = shooter.windows
    measured = np.isfinite(shooter.measured).reshape(len(windows), windows.blocks, windows.block, -1)
    used = np.repeat(measured.all(axis=2), windows.block, axis=1)
    unknown = ~shooter.torques_known
    if not unknown.all():
        used[unknown] = False
    return used


def _drawn(shooter: Shooter, x0: Array, residual: Array, used: Flags, seed: int) -> Array:
    """The residual from drawn noise of torques and sensors, if the model is right."""
    windows, draw = shooter.windows, np.random.default_rng(seed)
    noisy = Shooter(
        shooter.given, windows, draw.standard_normal((*used.shape[:2], shooter.model.n)) * windows.noise.tau
    )
    sensor = draw.standard_normal(used.shape) * windows.sensor_noise
    return np.where(used, residual - bounded_residual(noisy, noisy.run(x0), used) - sensor, 0.0)


def _fitting(x0: Array, model: FlexibleJointModel, shooter: Shooter) -> Array:
    """Convert first states of one model to those of another one; states that only the other has are computed by it."""
    if x0.shape[1] == shooter.size and (model.elastic == shooter.model.elastic).all():
        return x0
    return window_starts(shooter).x
