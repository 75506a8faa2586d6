"""The covariance of the residuals from sensor noise, and the whitening with it."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from flexdyn import _core
from flexdyn.arrays import Array, Flags
from flexdyn.diagnose.data.filters import Filters
from flexdyn.diagnose.equations.equations import Equations
from flexdyn.diagnose.equations.held_torque import HELD
from flexdyn.diagnose.equations.hidden_links import error_of_rests
from flexdyn.diagnose.equations.layout import MOTOR, TOTAL
from flexdyn.diagnose.equations.motion import SmoothedMotion
from flexdyn.diagnose.equations.noise_coefficients import Channel, Terms, coefficients, freest
from flexdyn.diagnose.equations.vibration_noise import VIBRATION_ROWS, vibration_noise
from flexdyn.diagnose.lazy import last

MASKED = 1e8
"""Variance of a masked row in units of the median one."""


@dataclass(frozen=True, eq=False)
class SampleNoise:
    """Standard deviations of white noise of a sample, by joint (n,), zero for a missing channel."""

    q: Array
    theta: Array
    tau: Array
    tau_s: Array

    def of_channels(self, channels: Sequence[str], joints: Sequence[str]) -> Array:
        """Of channels such as ``q.elbow`` (channels,); `joints` are the model's, in order."""
        places = (name.partition(".") for name in channels)
        return np.array([getattr(self, signal)[joints.index(joint)] for signal, _, joint in places])


@dataclass(frozen=True, eq=False)
class Whitener:
    """The banded Cholesky factor L of the residuals' covariance; masked rows have the weight zero.

    Attributes:
        factor: row by row, L(i, i - d) at (i, d), zero before the first column (rows, width).
        mask: rows that are not used (rows,).
    """

    factor: Array
    mask: Flags

    def __call__(self, rows: Array) -> Array:
        """White rows of unit variance (rows, ...); zero where masked."""
        raw = np.ascontiguousarray(rows.reshape(len(rows), -1).T, dtype=float)
        white = np.empty_like(raw)
        _core.whiten(self.factor, self.mask, raw, white)
        return np.asarray(white.T.reshape(rows.shape))

    def back(self, white: Array) -> Array:
        """L^-T of white rows (rows,)."""
        from scipy.linalg import solve_banded

        return np.asarray(solve_banded((0, self.factor.shape[1] - 1), self.factor[:, ::-1].T, white))

    def apart(self, raw: Array, white: NDArray[np.float32]) -> None:
        """White columns of raw ones (columns, rows), the equations one after another (equations, columns, times)."""
        _core.whiten_apart(self.factor, self.mask, np.ascontiguousarray(raw), white)


@last
def whitener(equations: Equations, noise: SampleNoise, mask: Flags, extra: Array | None = None) -> Whitener:
    """The whitening of the equations' rows; they keep it.

    Noise passes the same filters as the motion; a residual is ``sum_c sum_o C_co(t) d^o/dt^o n_c``, its covariance
    over a lag l of rows ``sum C_co(t + l) C_cp(t) R_op(l) sigma_c^2`` with the kernels' correlations R.

    Args:
        equations: whose residuals they are.
        noise: of the channels.
        mask: rows that are not used (rows,).
        extra: additional variance of the rows, such as the error of the filters at corners of a law (rows,).
    """
    from scipy.linalg import cholesky_banded

    many, counts = len(equations.kinds), equations.counts
    lags = len(_correlations(equations.filters, _twice(equations))["tau"])
    lags = min(max(lags, 2 * VIBRATION_ROWS - 1 if equations.simulated else 0), max(counts))
    band = np.zeros((many * sum(counts), many * lags))  # (row b, d): covariance of the rows b + d and b
    parts = np.split(band, many * np.cumsum(counts)[:-1])
    for along, part in zip(equations.motions, parts, strict=True):
        _add_noise(equations, along, noise, part, lags)
        if equations.simulated:
            _add_vibration(equations, along, noise, part)
    own = band[:, 0]
    if not equations.simulated:
        own += error_of_rests(equations)
    if extra is not None:
        own += extra
    own[:] = np.where(mask, own + MASKED * np.median(own), own * (1.0 + 1e-9))
    by_columns = cholesky_banded(band.T, lower=True, overwrite_ab=True, check_finite=False)
    factor = np.empty_like(band)
    _core.by_rows(np.ascontiguousarray(by_columns.T), factor)
    return Whitener(factor, mask)


def kernels_of(equations: Equations) -> dict[str, list[Array]]:
    """Whole kernels from a channel's noise to a row, by its signal and the order of the derivative."""
    return _kernels(equations.filters, _twice(equations))


def _twice(equations: Equations) -> bool:
    """Whether the whole motion passes the first filter once more, because a position is computed."""
    return bool(equations.computed.any() or equations.replayed.any())


@lru_cache(maxsize=16)
def _kernels(filters: Filters, twice: bool) -> dict[str, list[Array]]:
    first, second = filters.first.taps, filters.second.taps[0]
    whole = [np.convolve(second, taps) for taps in first]
    if twice:
        whole = [np.convolve(kernel, first[0]) for kernel in whole]
        whole += [np.convolve(np.convolve(second, once), first[2]) for once in first[1:]]
        whole.append(np.convolve(np.convolve(filters.second.taps[2], first[1]), first[2]))
    held = [np.convolve(kernel, HELD) for kernel in whole]
    return {"q": whole, "theta": whole, "tau": held, "tau_s": whole[:1]}


def _add_noise(equations: Equations, along: SmoothedMotion, noise: SampleNoise, band: Array, lags: int) -> None:
    """Add the covariance of one recording's rows to its band (rows, width)."""
    found, correlations = coefficients(equations, along), _correlations(equations.filters, _twice(equations))
    terms = [(channel, order) for channel, orders in found.items() for order in orders]
    table = np.zeros((equations.filters.count(len(along.t)), len(terms), len(equations.kinds)))
    weights = np.zeros((lags, len(terms), len(terms)))
    for k, (channel, order) in enumerate(terms):
        for row, value in found[channel][order].items():
            table[:, k, row] = value
        signal, j = channel
        R = correlations[signal][:lags]
        for m, (other, at) in enumerate(terms):
            if other == channel:
                weights[: len(R), k, m] = getattr(noise, signal)[j] ** 2 * R[:, order, at]
    _core.noise_band(table, weights, band)
    _add_what_stays(equations, along, found, band)


def _add_what_stays(
    equations: Equations, along: SmoothedMotion, found: dict[Channel, dict[int, Terms]], band: Array
) -> None:
    """Add errors of positions that no filter lessens, as they stay, to the band of one recording (rows, width).

    Their correlation falls to 0 at the width of the band; what lasts longer is part of the model error's memory.
    """
    many, at = len(equations.kinds), along.lost + equations.filters.instants(len(along.t))
    lags = band.shape[1] // many
    for (signal, j), orders in found.items():
        stays = np.asarray(getattr(along.data, f"{signal}_stays", 0.0))
        if 0 not in orders or not stays.any():
            continue
        rows = {row: coefficient * stays[at, j] for row, coefficient in orders[0].items()}
        for lag, later, now in itertools.product(range(lags), rows, rows):
            both = rows[later][lag:] * rows[now][: len(at) - lag]
            _add_to_band(band, many, 0, lag, later, now, (1.0 - lag / lags) * both)


def _add_vibration(equations: Equations, along: SmoothedMotion, noise: SampleNoise, band: Array) -> None:
    """Add the noise of links that vibrate to the band of one recording (rows, width)."""
    many = len(equations.kinds)
    for each in vibration_noise(equations, along, noise.theta, kernels_of(equations)["theta"][0]):
        for lag, of_lag in enumerate(each.covariance):
            both = each.share[lag:] * each.share[: len(each.share) - lag]
            for (later, now), value in np.ndenumerate(of_lag):
                _add_to_band(band, many, each.first, lag, later, now, value * both)


def _add_to_band(band: Array, many: int, first: int, lag: int, later: int, now: int, covariance: Array) -> None:
    """Add covariances of two equations, so many rows apart, from a row on; those above the diagonal are left out.

    Args:
        band: of one recording (rows, width).
        many: equations.
        first: row of an equation.
        lag: rows from the earlier one to the later one.
        later: equation of the later one.
        now: equation of the earlier one.
        covariance: (times,).
    """
    if lag * many + later >= now:
        begin = many * first + now
        band[begin : begin + many * len(covariance) : many, lag * many + later - now] += covariance


@lru_cache(maxsize=16)
def _correlations(filters: Filters, twice: bool) -> dict[str, Array]:
    """R between the kernels of each signal (lags, orders, orders)."""
    kernels = _kernels(filters, twice)
    shifts = range(0, max(len(kernel) for own in kernels.values() for kernel in own), filters.every)
    found = {
        signal: np.array([[[_correlation(a, b, shift) for b in own] for a in own] for shift in shifts])
        for signal, own in kernels.items()
        if signal != "theta"
    }
    return {**found, "theta": found["q"]}


def _correlation(a: Array, b: Array, shift: int) -> float:
    """R(shift) = sum_m a[m] b[m + shift] of centred kernels of any length."""
    ha, hb = len(a) // 2, len(b) // 2
    start = max(-ha, -hb - shift)
    stop = min(len(a) - ha, len(b) - hb - shift)
    if start >= stop:
        return 0.0
    return float(a[ha + start : ha + stop] @ b[hb + start + shift : hb + stop + shift])


def row_variances(
    equations: Equations, along: SmoothedMotion, noise: SampleNoise, row: int, j: int, *, second: bool
) -> tuple[Array, Array]:
    """Variances of one equation's rows from all channels except tau_j, and from tau_j with unit variance (times,) each.

    Args:
        equations: that have the rows.
        along: motion of one recording.
        noise: of the channels.
        row: index of the equation in `kinds`.
        j: joint of the torque.
        second: whether to use second differences of the rows instead of the rows.
    """
    kernels, every = kernels_of(equations), equations.filters.every
    weights = {-2: 1.0, -1: -4.0, 0: 6.0, 1: -4.0, 2: 1.0} if second else {0: 1.0}
    totals = np.zeros((2, equations.filters.count(len(along.t))))
    for (signal, i), orders in coefficients(equations, along).items():
        mine = signal == "tau" and i == j
        variance = 1.0 if mine else float(getattr(noise, signal)[i]) ** 2
        own = kernels[signal]
        for o, later in orders.items():
            for p, now in orders.items():
                R = sum(w * _correlation(own[o], own[p], lag * every) for lag, w in weights.items())
                totals[int(mine)] += later.get(row, 0.0) * now.get(row, 0.0) * (variance * R)
    return totals[0], totals[1]


def variances(equations: Equations, noise: SampleNoise, row: int, j: int) -> tuple[float, float]:
    """Medians of `row_variances` over the rows of the first recording that show most of the torque's noise."""
    along = equations.motions[0]
    free = freest(equations, along, j)
    others, unit = row_variances(equations, along, noise, row, j, second=False)
    return float(np.median(others[free])), float(np.median(unit[free]))


def vibration_rules(equations: Equations, noise: SampleNoise) -> bool:
    """Whether encoder noise that makes simulated links vibrate is more of some row's noise than all other noise."""
    postures = vibration_noise(equations, equations.motions[0], noise.theta, kernels_of(equations)["theta"][0])
    extra = np.mean([each.covariance[0] for each in postures], axis=0)
    for place, (j, _) in enumerate(equations.kinds):
        others, unit = variances(equations, noise, place, j)
        if extra[place, place] > others + unit * float(noise.tau[j]) ** 2:
            return True
    return False


def encoders_rule(equations: Equations, noise: SampleNoise) -> bool:
    """Whether in some motor's equation the encoders cause more noise than the torque."""
    for place, (j, kind) in enumerate(equations.kinds):
        if kind in (MOTOR, TOTAL):
            others, unit = variances(equations, noise, place, j)
            if others > unit * float(noise.tau[j]) ** 2:
                return True
    return False
