"""A motion as samples of positions, velocities and accelerations of links and rotors."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from flexdyn.arrays import Array
from flexdyn.errors import InputError
from flexdyn.model.flexible_joint_model import FlexibleJointModel
from flexdyn.records import derivatives
from flexdyn.records.given import as_recording

MOST_SAMPLES_ALONG = 4000
"""Largest number of samples of a recording that are used; of more, evenly spaced ones."""


@dataclass(frozen=True, eq=False)
class Along:
    """Samples of a motion.

    Attributes:
        q, v, a: of the links (samples, n) [rad, rad/s, rad/s^2].
        omega, alpha: of the rotors (samples, n).
        every: number of samples of the recording for each of these.
    """

    q: Array
    v: Array
    a: Array
    omega: Array
    alpha: Array
    every: int = 1


def along_samples(model: FlexibleJointModel, q: Array, v: Array, a: Array) -> Along:
    """Take samples as they are given; rotors move with their links.

    Raises:
        InputError: not all of one shape (samples, n), or numbers that are not finite.
    """
    for name, each in (("q", q), ("v", v), ("a", a)):
        if each.ndim != 2 or each.shape != (len(q), model.n) or not len(q):
            remedy = f"(samples, {model.n}), the same for q, v and a"
            raise InputError("wrong shape", key=name, value=each.shape, remedy=remedy)
        if not np.isfinite(each).all():
            raise InputError("numbers that are not finite", key=name)
    return Along(q, v, a, v, a)


def along_recording(model: FlexibleJointModel, recording: Any) -> Along:
    """Smooth and differentiate a recording; a missing encoder is replaced by the joint's other one.

    Raises:
        InputError: a joint without any position, or samples that cannot be differentiated.
    """
    recording = as_recording(recording, "motion", signals=True)
    channels = []
    for joint in model.joint_names:
        pair = [f"{signal}.{joint}" for signal in ("q", "theta") if recording.has(signal, joint)]
        if not pair:
            remedy = f"record q.{joint} or theta.{joint}"
            raise InputError("no position of the joint was recorded", key=joint, remedy=remedy)
        channels.append((pair[0], pair[-1]))
    seen = derivatives(recording, [name for name, _ in channels])
    every = max(1, -(-len(seen.t) // MOST_SAMPLES_ALONG))
    q, v, a = (np.stack([of(name) for name, _ in channels], axis=1) for of in (seen.value, seen.first, seen.second))
    omega, alpha = (np.stack([of(name) for _, name in channels], axis=1) for of in (seen.first, seen.second))
    return Along(q[::every], v[::every], a[::every], omega[::every], alpha[::every], every)
