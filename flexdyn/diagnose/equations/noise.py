"""The noise of the channels, estimated from the data."""

from __future__ import annotations

import numpy as np

from flexdyn.arrays import Array, Flags
from flexdyn.diagnose.data.channel_noise import recorded_torque_noise
from flexdyn.diagnose.equations.covariance import SampleNoise, freest, variances
from flexdyn.diagnose.equations.equations import Equations
from flexdyn.diagnose.equations.layout import MOTOR, TOTAL
from flexdyn.records.signals.reading_noise import robust_std

ENCODER_NOISE_SHARE = 0.5
"""Share of the residual's noise that encoders may make for the torque's to be told from it."""


def torque_noise(equations: Equations, left: Array, mask: Flags, encoders: SampleNoise) -> Array:
    """Standard deviation of each joint's torque channel (n,) [N m or N].

    Second differences of the residuals contain noise and hardly any missing effect. The part of the encoders is
    subtracted; the rest is noise of the torque, in the recording or at the motor. If the encoders cause most of it, as
    with a missing encoder, or where a limit of the motor cuts all of it, the changes of the recorded torque from sample
    to sample are used instead.

    Args:
        equations: of the fitted model.
        left: their residuals, not whitened (rows,).
        mask: rows that are not used.
        encoders: noise, with a torque noise of 1 for each joint.
    """
    many = len(equations.kinds)
    rows, hidden = left.reshape(-1, many), mask.reshape(-1, many)
    found = np.zeros(equations.true.n)
    for place, (j, kind) in enumerate(equations.kinds):
        if kind not in (MOTOR, TOTAL):
            continue
        second = rows[2:, place] - 2.0 * rows[1:-1, place] + rows[:-2, place]
        free = np.concatenate([freest(equations, along, j) for along in equations.motions])
        shut = hidden[:, place] | ~free
        clear = ~(shut[2:] | shut[1:-1] | shut[:-2])
        if clear.sum() < 20:
            clear[:] = True
        seen = robust_std(second[clear]) ** 2
        others, unit = variances(equations, encoders, place, j)
        if others > ENCODER_NOISE_SHARE * seen or unit <= 0.0:
            found[j] = recorded_torque_noise(equations.data)[j]
        else:
            found[j] = np.sqrt((seen - others) / unit)
    return found
