"""Recorded torques between their samples, and what a motor's law leaves of them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from flexdyn.arrays import Array
from flexdyn.records.signals.kernels import GaussianSmoother

HELD = (-1 / 24, 13 / 24, 13 / 24, -1 / 24)
"""Weights of the samples k - 2 to k + 1 of a held torque in its value at sample k, see `centred` [1]."""


@dataclass(frozen=True, eq=False)
class HeldTorque:
    """The recorded torques before any filter, held from each sample to the next.

    Attributes:
        tau: (samples of the recording, n).
        kernel: the first filter.
        passes: how often a torque passes it.
    """

    tau: Array
    kernel: GaussianSmoother
    passes: int

    def through(self, law: Callable[[Array], Array], j: int, many: int) -> Array:
        """A motor's torque after a law, smoothed as the recorded torque is (many,).

        A limit acts on the held torque: of a smoothed one it would leave another torque wherever the command jumps.

        Args:
            law: the torque after it (samples of the recording,) of that before it.
            j: the joint.
            many: samples that are wanted, the middle ones.
        """
        after = self.tau[:, j]
        before = np.concatenate([after[:1], after[:-1]])
        x = _sharpened(0.5 * (law(before) + law(after)))
        for _ in range(self.passes):
            x = self.kernel.apply(x, 0)
        spare = (len(x) - many) // 2
        return x[spare : spare + many]


def centred(tau: Array) -> Array:
    """A torque that is held from each sample to the next, as a smooth signal at the samples (samples, ...).

    ``(1 - d^2/12) (tau_k + tau_(k-1))/2`` with second differences d^2: `HELD`. The mean alone is the second difference
    of what the torque accelerates, over dt^2, and falls short of its second derivative by the factor 1 + d^2/12.
    """
    mean = tau.copy()
    mean[1:] = 0.5 * (tau[1:] + tau[:-1])
    return _sharpened(mean)


def _sharpened(mean: Array) -> Array:
    """(1 - d^2/12) of means over two samples; the first and the last one stay."""
    sharp = mean.copy()
    sharp[1:-1] -= (mean[2:] - 2.0 * mean[1:-1] + mean[:-2]) / 12.0
    return sharp
