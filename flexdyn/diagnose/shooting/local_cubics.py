"""A channel at the starts of windows, by local cubics over the samples before and after."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from flexdyn.arrays import Array
from flexdyn.diagnose.shooting.sensing import true_samples
from flexdyn.diagnose.shooting.shooter import Shooter

REACHES = (0.04, 0.02, 0.01, 0.005)
"""Half widths of the local cubic [s]; the widest one whose error is only noise is used."""
LEAST_REST_TIME = 0.02
"""A joint rests if it stays within its noise for this time before and after [s]."""
UNMEASURED = (0.0, 0.0, 0.0, 0.1, 0.1, 0.0)
"""Value, two derivatives, errors of value and rate, and whether it rests, where a channel was not recorded."""


def channel_at_starts(shooter: Shooter, name: str) -> Array:
    """One channel at every start (windows, 6): value, two derivatives, errors of value and rate, whether it rests."""
    windows = shooter.windows
    noise = windows.sensor_noise[windows.channels.index(name)]
    table = np.tile(UNMEASURED, (len(windows), 1))
    for k, recording in enumerate(windows.recordings):
        mine = windows.places[:, 0] == k
        if mine.any() and name in recording:
            rows, (t, x) = windows.places[mine, 1], true_samples(shooter.model, recording, name)
            table[mine] = _cubics(t, x, recording.t[rows], rows, noise, windows.period)
    return table


def _cubics(t: Array, x: Array, at: Array, rows: NDArray[np.int64], noise: float, period: float) -> Array:
    """Value, two derivatives, their errors and rest (starts, 6), by the widest cubic that leaves only noise."""
    best = np.full((len(rows), 6), np.nan)
    open_ = np.ones(len(rows), bool)
    for reach in REACHES:
        half = max(4, round(reach / period))
        near = rows[:, None] + np.arange(-half, half + 1)
        inside = (near >= 0) & (near < len(t))
        near = np.clip(near, 0, len(t) - 1)
        u = (t[near] - at[:, None]) / (half * period)
        inside &= np.abs(u) < 1.5  # not across a gap
        inside |= np.arange(2 * half + 1) == half
        weight = inside.astype(float)
        y = x[near]
        basis = weight[:, :, None] * u[:, :, None] ** np.arange(4)
        normal = basis.transpose(0, 2, 1) @ basis + 1e-9 * np.eye(4)
        inverse = np.linalg.inv(normal)
        first = y[:, half]
        fit = (inverse @ (basis.transpose(0, 2, 1) @ (weight * (y - first[:, None]))[:, :, None]))[:, :, 0]
        left = weight * (y - first[:, None]) - (basis @ fit[:, :, None])[:, :, 0]
        size = np.sqrt((left**2).sum(1) / np.maximum(weight.sum(1) - 4, 1.0))
        scale = 1.0 / (half * period)
        error = np.maximum(size, noise)
        value_std, rate_std = (error * np.sqrt(inverse[:, i, i]) for i in (0, 1))
        row = np.stack([
            first + fit[:, 0], fit[:, 1] * scale, 2.0 * fit[:, 2] * scale**2, value_std, rate_std * scale,
            np.zeros(len(rows)),
        ], axis=1)  # fmt: skip
        best[open_] = row[open_]
        open_ &= size > 1.3 * noise
        if not open_.any():
            break
    best[:, 5] = _resting(x, rows, max(3, round(LEAST_REST_TIME / period)), noise)
    return best


def _resting(x: Array, rows: NDArray[np.int64], half: int, noise: float) -> Array:
    """Whether a channel stays within its noise before and after the starts (starts,); a creeping one does not."""
    y = x[np.clip(rows[:, None] + np.arange(-half, half + 1), 0, len(x) - 1)]
    trend = np.abs(y[:, : half + 1].mean(1) - y[:, half:].mean(1))
    still = (y.max(1) - y.min(1) < 8.0 * noise) & (trend < 5.0 * noise / math.sqrt(half) + 1.5 * noise)
    return np.asarray(still, dtype=float)
