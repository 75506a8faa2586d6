"""Sampling rates: recordings with very high rates are decimated, those with low rates get advice."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

import numpy as np

from flexdyn.diagnose.data.measured import Measured, uniform
from flexdyn.model.flexible_joint_model import FlexibleJointModel
from flexdyn.records import Recording
from flexdyn.simulation.link_side import LinkSide

HIGHEST_KEPT_RATE = 2500.0
"""Higher rates are decimated [Hz]: no effect needs them, and the computing time grows with the rate."""
LEAST_KEPT_RATE = 1000.0
"""Smallest rate after decimating [Hz]."""
SLOW_RATE = 100.0
"""Below this rate reversals and impacts are between the samples [Hz]."""
ADVISED_RATE = 250.0
"""Recommended rate [Hz]."""
SAMPLES_IN_A_PERIOD = 5.0
"""With fewer samples in a period, a vibration can hardly be seen [1]."""


def at_needed_rates(recordings: Sequence[Recording]) -> tuple[tuple[Recording, ...], tuple[str, ...]]:
    """Recordings with at most 2500 Hz, and a sentence for each that was decimated."""
    found: list[Recording] = []
    said: list[str] = []
    for rec in recordings:
        factor = int(rec.rate / LEAST_KEPT_RATE * (1.0 + 1e-6))
        if rec.rate <= HIGHEST_KEPT_RATE or factor < 2:
            found.append(rec)
            continue
        found.append(uniform(rec).decimate(factor))
        name = rec.name or "A recording"
        said.append(
            f"{name} was recorded at {rec.rate:.5g} Hz and is used at {rec.rate / factor:.5g} Hz: its"
            f" positions through a symmetric FIR filter, its torques as means over {factor} samples."
        )
    return tuple(found), tuple(dict.fromkeys(said))


def advice(model: FlexibleJointModel, data: Sequence[Measured]) -> Iterator[str]:
    """Sentences that recommend a higher rate, with the reason.

    Args:
        model: as given.
        data: the recordings of the fit.
    """
    slowest = min(data, key=lambda each: 1.0 / each.dt)
    rate = 1.0 / slowest.dt
    name = slowest.name or "A recording"
    if rate < SLOW_RATE * (1.0 - 1e-6):
        yield (
            f"{name} has {rate:.4g} samples in a second: reversals and impacts lie between them, and effects that"
            f" differ there are hard to tell apart. Record at {ADVISED_RATE:g} Hz or more."
        )
    inertia = np.diag(LinkSide(model).mass_matrix(slowest.moved[len(slowest.t) // 2]))
    for j in np.flatnonzero(model.elastic):
        hertz = math.sqrt(float(model.stiffness[j]) / float(inertia[j])) / math.tau
        if rate < SAMPLES_IN_A_PERIOD * hertz:
            yield (
                f"{model.joint_names[j]} vibrates at about {hertz:.3g} Hz against its spring, and {name} has {rate:.4g}"
                f" samples in a second: record at {10.0 * hertz:.2g} Hz or more, or take the joint for rigid."
            )
