"""Recordings less the noise that their residual shows: slopes along them are independent of the residual."""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np
from numpy.typing import NDArray

from flexdyn.analysis.analysed_model import command_delays
from flexdyn.arrays import Array
from flexdyn.diagnose.data.filters import later
from flexdyn.diagnose.data.measured import SIGNALS, Measured
from flexdyn.diagnose.equations.covariance import SampleNoise, Whitener, kernels_of
from flexdyn.diagnose.equations.equations import Equations
from flexdyn.diagnose.equations.motion import SmoothedMotion
from flexdyn.diagnose.equations.noise_coefficients import Channel, Terms, coefficients
from flexdyn.effects.channels import by_channel, lag


def expected_data(equations: Equations, noise: SampleNoise, whiten: Whitener, scale: Array) -> tuple[Measured, ...]:
    """The recordings less the expected value of their noise, given what a hypothesis leaves.

    The residual is ``r = A n`` with the noise n of the channels. Where A depends on a number b, so do the slopes
    ``X + A' n``: they contain the noise of r, and ``E[X^T C^-1 r] = (1/2) d log|C|/db`` is not zero (errors in
    variables). The expected noise is ``m = S A^T C^-1 r`` with the variances S of the channels. Slopes along the
    recordings less m contain ``n - m``, which is uncorrelated with r. Their products with ``C^-1 r`` are the gradient
    of ``r^T C(b)^-1 r / 2``, with a covariance C that follows b: the maximum of the likelihood.

    Args:
        equations: of the hypothesis.
        noise: of the channels.
        whiten: of the rows.
        scale: size of the model error over the noise of the rows (equations,) [1]; a residual that is mostly model
            error says little of the noise.
    """
    many = len(equations.kinds)
    white = whiten(equations.residual).reshape(-1, many) / scale**2
    weighted = whiten.back(white.ravel()).reshape(-1, many)
    each = zip(equations.data, equations.motions, equations.by_recording(weighted), strict=True)
    return tuple(_less_noise(equations, noise, *one) for one in each)


def _less_noise(
    equations: Equations, noise: SampleNoise, data: Measured, along: SmoothedMotion, rows: Array
) -> Measured:
    """One recording less S A^T of its weighted rows (times, equations)."""
    columns: dict[str, Any] = {signal: getattr(data, signal).copy() for signal in SIGNALS}
    at = along.lost + equations.filters.instants(len(along.t))
    sensors = by_channel(equations.model.effects)
    for channel, orders in coefficients(equations, along).items():
        signal, j = channel
        variance = float(getattr(noise, signal)[j]) ** 2
        found = variance * onto_samples(equations, channel, orders, rows, at, len(data.t))
        late = lag(sensors.get(f"{signal}.{equations.true.joint_names[j]}", ()))
        # The recorded channel has it later by the lag that is taken off for the rows, and a late command acts later.
        late -= float(command_delays(equations.model)[j]) if signal == "tau" else 0.0
        columns[signal][:, j] -= later(data.t, found, late) if late else found
    return dataclasses.replace(data, **columns)


def onto_samples(
    equations: Equations, channel: Channel, orders: dict[int, Terms], rows: Array, at: NDArray[np.intp], samples: int
) -> Array:
    """A^T of rows: what rows say of the samples of one channel (samples,).

    Args:
        equations: that have the rows.
        channel: of which samples.
        orders: its coefficients, by order of the derivative and by equation.
        rows: (times, equations).
        at: samples to which the rows belong (times,).
        samples: of the channel.
    """
    kernels = kernels_of(equations)[channel[0]]
    total = np.zeros(samples)
    for order, terms in orders.items():
        sparse = np.zeros(samples)
        sparse[at] = sum(coefficient * rows[:, row] for row, coefficient in terms.items())
        half = len(kernels[order]) // 2
        total += np.convolve(sparse, kernels[order])[half : half + samples]
    return total
