"""Samples of recordings: several channels as one array, and all channels compared bit for bit."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from flexdyn.checks import Array

if TYPE_CHECKING:
    from flexdyn.records.recording import Recording


def side_by_side(rec: Recording, signal: str, joints: Sequence[str]) -> Array:
    """One signal of several joints, a new array (samples, len(joints)).

    Raises:
        InputError: a joint lacks the signal.
    """
    table = np.empty((len(rec.t), len(joints)))
    for column, joint in enumerate(joints):
        table[:, column] = rec[f"{signal}.{joint}"]
    return table


def same_samples(one: Recording, other: Recording) -> bool:
    """Whether times and channels are the same, bit for bit and in order.

    Args:
        one: a recording.
        other: another.
    """
    if tuple(one.channels) != tuple(other.channels) or len(one) != len(other):
        return False
    pairs = [(one.t, other.t), *((one.channels[name], other.channels[name]) for name in one.channels)]
    return all(np.array_equal(mine.view(np.int64), theirs.view(np.int64)) for mine, theirs in pairs)
