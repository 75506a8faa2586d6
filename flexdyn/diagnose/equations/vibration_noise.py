"""Encoder noise that makes links vibrate which are simulated behind their motors."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from flexdyn.arrays import Array, Indices
from flexdyn.diagnose.equations.equations import Equations
from flexdyn.diagnose.equations.layout import TOTAL
from flexdyn.diagnose.equations.motion import SmoothedMotion

VIBRATION_ROWS = 16
"""Rows between the postures at which the vibration of links by encoder noise is computed: behind the narrowest filter
0.16 s, in which its frequency hardly changes. Rows twice as far apart are taken for independent."""
FREQUENCIES = 4096
"""Between zero and half of the sampling rate, at which this vibration is summed up."""
PASSED = 1e-6
"""Power that the filters pass, over the greatest, below which a frequency is left out [1]."""


@dataclass(frozen=True, eq=False)
class VibrationNoise:
    """Noise of the rows near one posture, by encoder noise that makes simulated links vibrate.

    Attributes:
        first: row of an equation, in its recording.
        share: root of the posture's share in the noise of the rows from there (times,) [1].
        covariance: of an equation so many rows later and another one (times, equations, equations).
    """

    first: int
    share: Array
    covariance: Array


def vibration_noise(equations: Equations, along: SmoothedMotion, theta: Array, taps: Array) -> list[VibrationNoise]:
    """Noise of one recording's rows by encoder noise that makes simulated links vibrate, posture by posture.

    Noise n of a motor's position moves the links by ``H n`` with ``H = (K + i w D - w^2 M)^-1 (K + i w D)``, and the
    rows have ``-w^2 M H n``. What it would do on rigid joints is not in it: the rows' covariance holds that.

    The vibration stands out at a frequency that changes with the posture. Taken for white noise, less of it would look
    like a better model, and more damping makes less of it. The shares of two neighbouring postures add up to one, so
    that the sum is a covariance.

    Args:
        equations: whose links are simulated.
        along: motion of the recording.
        theta: standard deviations of the motors' encoders (n,) [rad or m].
        taps: whole filter from a sample to a row.
    """
    many, count = len(equations.kinds), equations.filters.count(len(along.t))
    places = [(place, j) for place, (j, kind) in enumerate(equations.kinds) if kind == TOTAL]
    chosen, rows = (list(each) for each in zip(*places, strict=True))
    hidden = np.flatnonzero(equations.unmeasured)
    turn = np.linspace(0.0, np.pi, FREQUENCIES + 1)[1:]
    passed = np.abs(np.fft.rfft(taps, 2 * FREQUENCIES)[1:]) ** 2 * turn**4
    heard = passed > PASSED * passed.max()
    w, passed = turn[heard] / along.dt, passed[heard] / along.dt**4 / FREQUENCIES
    lags = np.arange(2 * VIBRATION_ROWS - 1)
    later = np.exp(1j * turn[heard] * equations.filters.every * lags[:, None]) * passed
    inertias, found = along.inertias(equations.filters), []
    for centre in range(0, count - 1 + VIBRATION_ROWS, VIBRATION_ROWS):
        M = inertias[min(centre, count - 1)]
        loads = M[np.ix_(rows, hidden)] / equations.gains[rows, None]
        moves = _moved_by_motors(M[np.ix_(hidden, hidden)], equations, hidden, w)
        rigid, swung = loads * theta[hidden], loads @ moves * theta[hidden]
        power = swung @ swung.conj().transpose(0, 2, 1) - rigid @ rigid.T
        covariance = np.zeros((len(lags), many, many))
        covariance[np.ix_(lags, chosen, chosen)] = np.tensordot(later, power, 1).real
        at = np.arange(max(centre - VIBRATION_ROWS + 1, 0), min(centre + VIBRATION_ROWS, count))
        share = np.sqrt(1.0 - np.abs(at - centre) / VIBRATION_ROWS)
        found.append(VibrationNoise(int(at[0]), share, covariance[: len(at)]))
    return found


def _moved_by_motors(M: Array, equations: Equations, hidden: Indices, w: Array) -> NDArray[np.complex128]:
    """H (frequencies, links, links): how far links move with their motors, by the poles of ``M q'' + D q' + K q``."""
    K, D = (np.diag(each[hidden]) for each in (equations.true.stiffness, equations.true.damping))
    n, inverse = len(M), np.linalg.inv(M)
    poles, modes = np.linalg.eig(np.block([[np.zeros((n, n)), np.eye(n)], [-inverse @ K, -inverse @ D]]))
    left = np.linalg.solve(modes, np.concatenate([np.zeros((n, n)), inverse]).astype(complex))
    residues = np.einsum("ik,kj,kjl->kil", modes[:n], left, K + poles[:, None, None] * D)
    return np.asarray(np.tensordot(1.0 / (1j * w[:, None] - poles), residues, 1))
