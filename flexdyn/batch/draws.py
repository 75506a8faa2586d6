"""What run k of a study is: every number that varies, from (seed, k) alone."""

from __future__ import annotations

from hashlib import blake2b

from flexdyn.batch.distributions import Distribution, Grid
from flexdyn.batch.study import Study


def drawn(study: Study, k: int) -> dict[str, float]:
    """The numbers of run k by their path, in the order of ``vary``.

    The points of the grid are counted with the last path changing fastest, and each has ``study.runs`` runs one after
    the other. A random number depends on seed, k and its own path only: neither the other paths nor their order
    change it.

    Args:
        study: the study.
        k: from 0 to ``study.count - 1``.
    """
    kinds, point = study.kinds, k // study.runs
    values: dict[str, float] = {}
    for path in reversed(list(kinds)):
        kind = kinds[path]
        if isinstance(kind, Distribution):
            values[path] = kind.value(share(study.seed, path, k))
        elif isinstance(kind, Grid):
            point, place = divmod(point, len(kind.values))
            values[path] = kind.values[place]
    return {path: values[path] for path in kinds}


def share(seed: int, path: str, k: int) -> float:
    """A random number, uniform over 0 < share < 1, the same on every machine.

    It is a counter-based generator whose block function is BLAKE2b, keyed by seed and path and counting in k; the upper
    52 bits of a block are taken.
    """
    key = blake2b(f"{seed}/{path}".encode(), digest_size=32).digest()
    block = blake2b(k.to_bytes(16, "little"), digest_size=8, key=key).digest()
    return ((int.from_bytes(block, "little") >> 12) + 0.5) * 2.0**-52
