"""The division into fit data and test data; only the final figures and the verdict use the test data."""

from __future__ import annotations

import math
import warnings
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Any

import numpy as np

from flexdyn.arrays import Flags
from flexdyn.checks import as_number
from flexdyn.diagnose.constants import REST_SIGMAS, TEST_SHARE
from flexdyn.diagnose.data.channel_noise import encoder_noise
from flexdyn.diagnose.data.measured import Measured, measured
from flexdyn.diagnose.equations.covariance import SampleNoise
from flexdyn.diagnose.equations.sanity import moves_long_enough
from flexdyn.diagnose.report.origin import RecordingSpan, Role
from flexdyn.errors import InputError
from flexdyn.model.flexible_joint_model import FlexibleJointModel
from flexdyn.records import Recording, RecordingWarning
from flexdyn.records.signals.cut import samples_between

SHORTEST_TEST_DATA = 1.0
"""Least length of such test data, of a block, and of a piece between blocks [s]: two windows of 0.5 s."""
FEWEST_TEST_SAMPLES = 100
"""Least number of samples of such test data: at a slow clock the two filters take 20 at either end."""
SHORTEST_CUT_RECORDING = 2.5
"""Shorter recordings are not cut, because the rest would be too short to fit [s]."""
MOVING_TIME = 0.2
"""Time over which a joint must change its position to count as moving [s]."""
Block = tuple[float, float]
Recordings = tuple[Recording, ...]


@dataclass(frozen=True, eq=False)
class DataPart:
    """A span of a recording and what it is used for.

    Attributes:
        recording: its samples, as recorded.
        data: the same on a uniform clock; time goes on counting from the start of the whole recording.
        role: fit or test.
    """

    recording: Recording
    data: Measured
    role: Role

    def source(self, joints: Sequence[str], noise: SampleNoise) -> RecordingSpan:
        """As the report tells it.

        Args:
            joints: of the model.
            noise: of the channels.
        """
        data, t = self.data, self.recording.t
        there = {"q": data.has_q, "theta": data.has_theta, "tau": np.ones_like(data.has_q)}
        levels = {
            f"{signal}.{joint}": float(getattr(noise, signal)[j])
            for signal, has in there.items()
            for j, joint in enumerate(joints)
            if has[j]
        }
        channels = tuple(self.recording.channels)
        return RecordingSpan(
            self.recording.name, self.role, float(t[0]), float(t[-1]), 1.0 / data.dt, levels, len(t), channels
        )


Parts = tuple[tuple[DataPart, ...], tuple[DataPart, ...]]


def parts(model: FlexibleJointModel, fit: Sequence[Recording], check: Sequence[Recording] = ()) -> Parts:
    """What is fitted, and the test data.

    Args:
        model: that names the joints.
        fit: recordings to learn from.
        check: test data; none: the last fifth of the motion in every recording of `fit`, or the last ones of short
            recordings. Where too little would be left to fit, all is fitted, and nothing is test data.

    Raises:
        InputError: a recording that does not fit the model.
    """
    whole = tuple(DataPart(each, measured(model, each), "fit") for each in fit)
    if check:
        return whole, tuple(DataPart(each, measured(model, each), "test") for each in check)
    kept = _kept_apart(whole)
    return kept if kept[0] and moves_long_enough([each.data for each in kept[0]]) else (whole, ())


def _kept_apart(whole: tuple[DataPart, ...]) -> Parts:
    """What would be fitted, and test data; nothing to fit where a lone recording is too short to be cut."""
    if any(each.data.t[-1] < SHORTEST_CUT_RECORDING for each in whole):
        return _apart(whole)
    halves = [_halves(each.recording, each.data) for each in whole]
    return tuple(first for first, _ in halves), tuple(last for _, last in halves)


def _apart(whole: tuple[DataPart, ...]) -> Parts:
    """Recordings too short to be cut: the last ones are test data as they are, until these hold the test share."""
    seconds = [float(moving(each.data).sum()) * each.data.dt for each in whole]
    first = len(whole) - 1
    while first > 1 and sum(seconds[first:]) < TEST_SHARE * sum(seconds):
        first -= 1
    return whole[:first], tuple(replace(each, role="test") for each in whole[first:])


def _halves(recording: Recording, data: Measured) -> tuple[DataPart, DataPart]:
    """A recording before and after the instant from which the test share of what moves lies."""
    at = _cut(data)
    row = int(np.searchsorted(recording.t, recording.t[0] + data.t[at] - 0.5 * data.dt))
    first = DataPart(samples_between(recording, 0, row), data.part(0, at), "fit")
    return first, DataPart(samples_between(recording, row, len(recording)), data.part(at, len(data.t)), "test")


def _cut(data: Measured) -> int:
    """First sample of the test data."""
    moves = np.flatnonzero(moving(data))
    if not len(moves):
        moves = np.arange(len(data.t))
    at = int(moves[int((1.0 - TEST_SHARE) * len(moves))])
    least = max(round(SHORTEST_TEST_DATA / data.dt), min(FEWEST_TEST_SAMPLES, len(data.t) // 2))
    return min(at, len(data.t) - 1 - least)


def moving(data: Measured) -> Flags:
    """Samples (samples,) about which some measured position changes by more than noise."""
    from scipy.ndimage import maximum_filter1d, minimum_filter1d

    width = max(2, round(MOVING_TIME / data.dt))
    moves = np.zeros(len(data.t), bool)
    for signal, there in (("q", data.has_q), ("theta", data.has_theta)):
        sigma = encoder_noise((data,), signal)
        for j in np.flatnonzero(there):
            x = getattr(data, signal)[:, j]
            moves |= maximum_filter1d(x, width) - minimum_filter1d(x, width) > REST_SIGMAS * sigma[j]
    return moves


def checked_blocks(given: Any) -> tuple[Block, ...]:
    """Pairs of first and last time [s].

    Raises:
        InputError: something else, or a block that is too short for a test.
    """
    remedy = "give pairs of first and last time in s, such as [(3.0, 5.0)]"
    if isinstance(given, str) or not isinstance(given, Iterable):
        raise InputError("blocks are needed", key="hold_out", value=given, remedy=remedy)
    found = []
    for entry in given:
        ends = [as_number(end) for end in entry] if isinstance(entry, Sequence) and not isinstance(entry, str) else []
        if len(ends) != 2 or not all(map(math.isfinite, ends)):
            raise InputError("a block is a first and a last time", key="hold_out", value=entry, remedy=remedy)
        if ends[1] - ends[0] < SHORTEST_TEST_DATA:
            problem = f"a block of {ends[1] - ends[0]:.4g} s is too short for a test"
            raise InputError(problem, key="hold_out", value=entry, remedy=f"give {SHORTEST_TEST_DATA:g} s or more")
        found.append((ends[0], ends[1]))
    return tuple(found)


def without_blocks(recordings: Sequence[Recording], blocks: Sequence[Block]) -> tuple[Recordings, Recordings]:
    """What is outside the blocks of each recording, in pieces, and what is inside.

    Args:
        recordings: each with times of its own.
        blocks: first and last time [s], of every recording that reaches there.

    Warns:
        RecordingWarning: a piece between blocks is too short and left out.

    Raises:
        InputError: a block in which no recording has enough samples, or nothing outside them.
    """
    rest: list[Recording] = []
    inside: list[Recording] = []
    met: set[int] = set()
    for rec in recordings:
        which = np.full(len(rec), -1)
        for k, (first, last) in enumerate(blocks):
            which[(rec.t >= first) & (rec.t <= last)] = k
        edges = [0, *(np.flatnonzero(np.diff(which)) + 1).tolist(), len(rec)]
        for low, high in pairwise(edges):
            k, length = int(which[low]), float(rec.t[high - 1] - rec.t[low])
            if length < SHORTEST_TEST_DATA - 2.0 * rec.duration / len(rec):
                if k < 0:
                    problem = f"{length:.3g} s from t = {rec.t[low]:.6g} s on are too short to fit"
                    warnings.warn(f"{rec.name}: {problem} and left out", RecordingWarning, stacklevel=4)
                continue
            (inside if k >= 0 else rest).append(rec.trim(float(rec.t[low]), float(rec.t[high - 1])))
            met.add(k)
    for k, block in enumerate(blocks):
        if k not in met:
            spans = "; ".join(f"{rec.name or 'a recording'} {rec.t[0]:.6g} to {rec.t[-1]:.6g} s" for rec in recordings)
            problem = f"no recording has {SHORTEST_TEST_DATA:g} s in this block"
            raise InputError(
                problem, key="hold_out", value=f"{block[0]:g} to {block[1]:g} s", remedy=f"there are {spans}"
            )
    if not rest:
        raise InputError("nothing is left to fit", key="hold_out", remedy="keep less apart")
    return tuple(rest), tuple(inside)
