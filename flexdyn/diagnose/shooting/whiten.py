"""Whitening of the residuals of windows: a Kalman filter on the linear response to first state and torque noise."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from typing import Self

import numpy as np

from flexdyn import _core
from flexdyn.arrays import Array, Flags
from flexdyn.diagnose.shooting.spread import LARGEST_SLOPE, Indices, Spread
from flexdyn.diagnose.shooting.windows import Index, PerWindow, Windows

EXCUSED_SHARE = 0.2
"""Largest standard deviation from noise, relative to a channel's range [1]: an unstable model amplifies noise."""


@dataclass(frozen=True, eq=False)
class Filter(PerWindow):
    """A filter with the propagation of noise through every window; it is linear in the residuals.

    Its state is the error e of the simulated state (simulated - true): e' = flow e + torque noise, and the block means
    of the residual are ``seen e`` + sensor noise. The error at the window's start is estimated along with it.

    Attributes:
        response: of the windows.
        gain: of the state's error by innovation (windows, blocks, nx, channels).
        first_gain: of the first state's error by innovation, likewise.
        whitener: inverse Cholesky factors of the innovations' covariances (windows, blocks, channels, channels).
        variance: of a single sample of the residual after the best first state (windows, blocks, channels).
        unfitted: the same with the true first state.
        counted: 1 if a block was measured, else 0 (windows, blocks, channels).
        block: number of samples in a block.
        wild: windows in which the noise covers any error (windows,).
    """

    response: Spread
    gain: Array
    first_gain: Array
    whitener: Array
    variance: Array
    unfitted: Array
    counted: Array
    block: int
    wild: Flags

    @classmethod
    def of(cls, windows: Windows, response: Spread, prior: Array, used: Flags, which: Indices) -> Filter:
        """Compute the covariances for some windows.

        Args:
            windows: all windows, with the noise levels.
            response: linear response of the selected windows.
            prior: covariance of the first states (windows, nx, nx).
            used: samples that count (windows, rows, channels).
            which: selected windows.
        """
        flow, push = response.flow, response.push
        count, blocks, nx, _ = flow.shape
        counted = used[which, :: windows.block].astype(float)
        sensor = windows.sensor_noise**2
        R = np.where(counted > 0, sensor / _independent_samples(windows, which), 1.0)
        channels = len(sensor)
        gain, first_gain = np.empty((count, blocks, nx, channels)), np.empty((count, blocks, nx, channels))
        whitener = np.empty((count, blocks, channels, channels))
        carried, doubt = np.empty((count, blocks, channels)), np.empty((count, blocks, channels))
        _core.window_gains(
            flow, push, response.seen, counted, R, np.ascontiguousarray(prior[which]), LARGEST_SLOPE,
            gain, first_gain, whitener, carried, doubt,
        )  # fmt: skip
        most = (EXCUSED_SHARE * windows.span) ** 2
        left = carried - doubt
        variance = sensor + np.clip(left, 0.0, most)
        unfitted = sensor + np.minimum(carried, most)
        wild = np.asarray(((carried > most) | (left > most)).any(axis=(1, 2)))
        return cls(response, gain, first_gain, whitener, variance, unfitted, counted, windows.block, wild)

    def replaced(self, which: Index, other: Self) -> Self:
        """See the base class; the response too."""
        return dataclasses.replace(
            super().replaced(which, other), response=self.response.replaced(which, other.response)
        )

    def _run(self, residual: Array, error: Array) -> tuple[Array, Array]:
        """Whitened innovations (windows, blocks, channels) and estimated errors of the first states (windows, nx)."""
        count, rows, channels = residual.shape
        mean = residual.reshape(count, rows // self.block, self.block, channels).mean(axis=2) * self.counted
        white, first = np.empty_like(mean), np.array(error)
        _core.window_innovations(
            self.response.flow, self.response.seen, self.counted, LARGEST_SLOPE,
            self.gain, self.first_gain, self.whitener, mean, first, white,
        )  # fmt: skip
        return white, first

    def first_error(self, residual: Array, moved: Array) -> Array:
        """Estimated errors of the first states from all measurements (windows, nx); moved: from the prior's centre."""
        return self._run(residual, moved)[1]

    def whitened(self, residual: Array, moved: Array) -> Array:
        """Innovations of unit variance (windows, blocks * channels)."""
        return self._run(residual, moved)[0].reshape(len(residual), -1)

    @property
    def log_determinant(self) -> Array:
        """Logarithm of the determinant of the innovations' covariance (windows,)."""
        roots = np.abs(np.diagonal(self.whitener, axis1=2, axis2=3))
        return np.asarray(-2.0 * np.log(np.maximum(roots, 1e-300)).sum(axis=(1, 2)))

    def scaled(self, residual: Array) -> Array:
        """Sum of squares of a residual in units of `variance`, of every window (windows,)."""
        blocks = residual.reshape(len(residual), -1, self.block, residual.shape[2])
        return np.asarray(((blocks**2).sum(axis=2) / self.variance * self.counted).sum(axis=(1, 2)))


def _independent_samples(windows: Windows, which: Indices) -> Array:
    """Independent samples in every block (windows, blocks, channels): an encoder that rests repeats its error."""
    samples = windows.measured[which].reshape(len(which), windows.blocks, windows.block, -1)
    moves = (samples != samples[:, :, :1]).any(axis=2)
    return np.where(moves, float(windows.block), 1.0)
