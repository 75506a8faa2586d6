"""Blocks of recordings that are test data."""

from __future__ import annotations

import math
import warnings
from collections.abc import Iterable, Sequence
from itertools import pairwise
from typing import Any

import numpy as np

from flexdyn.checks import as_number
from flexdyn.errors import InputError
from flexdyn.records import Recording, RecordingWarning

SHORTEST_BLOCK = 1.0
"""Least length of a block, and of a piece between blocks [s]: two windows of 0.5 s."""
Block = tuple[float, float]


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
        if ends[1] - ends[0] < SHORTEST_BLOCK:
            problem = f"a block of {ends[1] - ends[0]:.4g} s is too short for a test"
            raise InputError(problem, key="hold_out", value=entry, remedy=f"give {SHORTEST_BLOCK:g} s or more")
        found.append((ends[0], ends[1]))
    return tuple(found)


def without_blocks(
    recordings: Sequence[Recording], blocks: Sequence[Block]
) -> tuple[tuple[Recording, ...], tuple[Recording, ...]]:
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
            if length < SHORTEST_BLOCK - 2.0 * rec.duration / len(rec):
                if k < 0:
                    problem = f"{length:.3g} s from t = {rec.t[low]:.6g} s on are too short to fit"
                    warnings.warn(f"{rec.name}: {problem} and left out", RecordingWarning, stacklevel=3)
                continue
            (inside if k >= 0 else rest).append(rec.trim(float(rec.t[low]), float(rec.t[high - 1])))
            met.add(k)
    for k, block in enumerate(blocks):
        if k not in met:
            spans = "; ".join(f"{rec.name or 'a recording'} {rec.t[0]:.6g} to {rec.t[-1]:.6g} s" for rec in recordings)
            problem = f"no recording has {SHORTEST_BLOCK:g} s in this block"
            raise InputError(
                problem, key="hold_out", value=f"{block[0]:g} to {block[1]:g} s", remedy=f"there are {spans}"
            )
    if not rest:
        raise InputError("nothing is left to fit", key="hold_out", remedy="keep less apart")
    return tuple(rest), tuple(inside)
