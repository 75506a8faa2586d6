"""How large the effects of a structure are, as shares of torque, and how much of that no other effect can do."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from flexdyn.arrays import Array, Indices
from flexdyn.diagnose.inference.candidate import Candidate
from flexdyn.diagnose.inference.gram import Gram


def torque_share(candidate: Candidate, size: Array, mean: Array) -> float:
    """Root mean square torque of a candidate over that of its joint; an effect that stands has its present one.

    Args:
        candidate: of which.
        size: of its columns, as shares of the torque (width,).
        mean: its coefficients (width,).
    """
    parts = size * mean
    return float(np.linalg.norm(parts if candidate.stands is None else parts[:1]))


def share_apart(gram: Gram, columns: Indices, mean: Array, others: Sequence[Indices]) -> float:
    """Share of what some columns do that others cannot [1]; what every structure has is taken off both first.

    Args:
        gram: products of the columns.
        columns: that do it (k,).
        mean: their coefficients (k,).
        others: that might do it as well.
    """
    between, there = gram.between, np.concatenate(others)
    whole = float(mean @ between(columns, columns) @ mean)
    cross = between(there, columns) @ mean
    explained = float(cross @ np.linalg.lstsq(between(there, there), cross, rcond=1e-9)[0])
    return math.sqrt(min(max(1.0 - explained / max(whole, 1e-300), 0.0), 1.0))
