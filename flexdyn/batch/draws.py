"""The numbers of run k of a study, from (seed, k) alone."""

from __future__ import annotations

from collections.abc import Iterable
from hashlib import blake2b

import numpy as np

from flexdyn.arrays import Array
from flexdyn.batch.distributions import Distribution
from flexdyn.batch.study import Study


def draws_of_run(study: Study, k: int) -> dict[str, float]:
    """The numbers of run k by their path, in the order of ``vary``.

    Args:
        study: the study.
        k: from 0 to ``study.count - 1``.
    """
    return {path: float(column[0]) for path, column in draws_of_runs(study, range(k, k + 1)).items()}


def draws_of_runs(study: Study, runs: range) -> dict[str, Array]:
    """The numbers of some runs (runs,) by their path, in the order of ``vary``.

    The points of the grid are counted with the last path changing fastest, and each has ``study.runs`` runs one after
    the other. A random number depends on seed, k and its own path only: neither the other paths nor their order
    change it.

    Args:
        study: the study.
        runs: from 0 to ``study.count - 1``.
    """
    points = [k // study.runs for k in runs]
    columns: dict[str, Array] = {}
    for path, kind in reversed(list(study.kinds.items())):
        if isinstance(kind, Distribution):
            columns[path] = kind.values(uniform_draws(study.seed, path, runs))
        else:
            count = len(kind.values)
            columns[path] = np.array([kind.values[point % count] for point in points])
            points = [point // count for point in points]
    return {path: columns[path] for path in study.kinds}


def uniform_draws(seed: int, path: str, runs: Iterable[int]) -> Array:
    """A random number for each run, uniform over 0 < share < 1, the same on every machine.

    The generator is counter-based: BLAKE2b with seed and path as key and k as counter; the upper 52 bits of a block are
    used.
    """
    start = blake2b(digest_size=8, key=blake2b(f"{seed}/{path}".encode(), digest_size=32).digest())
    blocks = []
    for k in runs:
        block = start.copy()
        block.update(k.to_bytes(16, "little"))
        blocks.append(block.digest())
    upper = np.frombuffer(b"".join(blocks), dtype="<u8") >> np.uint64(12)
    return (upper.astype(np.float64) + 0.5) * 2.0**-52
