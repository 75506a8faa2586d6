"""Channels without the errors that the residual shows: the motion along which slopes are computed."""

from __future__ import annotations

import dataclasses

import numpy as np

from flexdyn.arrays import Array
from flexdyn.diagnose.data.measured import Measured
from flexdyn.diagnose.equations.covariance import Channel, SampleNoise, Whitener, coefficients, kernels_of
from flexdyn.diagnose.equations.equations import Equations


def expected_data(equations: Equations, noise: SampleNoise, whiten: Whitener, scale: Array) -> tuple[Measured, ...]:
    """The channels less the expected value of their noise, given the residual.

    A residual ``r = A n`` of the noise n of the channels has slopes ``X + A' n``, which are not independent of it:
    ``E[X^T C^-1 r] = (1/2) d log|C|/db`` and not zero (errors in variables). With ``n' = S A^T C^-1 r``, the expected
    noise given the residual, slopes along the channels less n' contain ``n - n'``, which is uncorrelated with r. The
    normal equations of these slopes are the gradient of ``r^T C(b)^-1 r / 2`` with the covariance following b.

    Args:
        equations: of the hypothesis.
        noise: of the channels.
        whiten: of its rows.
        scale: size of a model error over the noise of the rows, by equation (equations,); 1: none.
    """
    white = whiten(equations.residual) / np.tile(scale**2, len(whiten.mask) // len(scale))
    weighted = np.where(whiten.mask, 0.0, whiten.back(white)).reshape(-1, len(equations.kinds))
    kernels, first, found = kernels_of(equations), 0, []
    for along in equations.motions:
        times = equations.filters.count(len(along.t))
        rows = weighted[first : first + times]
        first += times
        at = along.lost + equations.filters.instants(len(along.t))
        columns = {name: along.data.channel(name).copy() for name in ("q", "theta", "tau", "tau_s")}
        raw = next(data for data in equations.data if data.name == along.data.name and len(data.t) == len(along.data.t))
        columns = {name: raw.channel(name).copy() for name in columns}
        for channel, orders in coefficients(equations, along).items():
            columns[channel[0]][:, channel[1]] -= _share(channel, orders, rows, at, kernels, len(raw.t)) * (
                float(getattr(noise, channel[0])[channel[1]]) ** 2
            )
        found.append(dataclasses.replace(raw, **columns))
    return tuple(found)


def _share(channel: Channel, orders, rows: Array, at, kernels, samples: int) -> Array:
    """A^T of weighted rows (times, equations) for one channel (samples,)."""
    group = kernels["position" if channel[0] in ("q", "theta") else channel[0]]
    total = np.zeros(samples)
    for order, terms in orders.items():
        sparse = np.zeros(samples)
        sparse[at] = sum(coefficient * rows[:, row] for row, coefficient in terms.items())
        kernel = group[order]
        half = len(kernel) // 2
        total += np.convolve(sparse, kernel)[half : half + samples]
    return total
