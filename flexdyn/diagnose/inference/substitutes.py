"""How much of what an effect of a structure does another one could do in its place."""

from __future__ import annotations

import numpy as np

from flexdyn.arrays import Array, Indices
from flexdyn.diagnose.inference.space import Space, Structure
from flexdyn.diagnose.inference.torque_shares import share_apart, torque_share


def own_share(space: Space, structure: Structure, c: int, other: int) -> float:
    """Share of its joint's torque that a candidate of a structure has and another one in its place cannot make [1].

    Beside what every structure has: the file's numbers, and a small amount of every law, which stands for what no
    model resolves.
    """
    columns, mean = _made(space, structure, c)
    share = torque_share(space.candidates[c], space.matrix.size[columns], mean)
    return share * share_apart(space.gram, columns, mean, [space.candidates[other].columns[0]])


def in_common(space: Space, structure: Structure, c: int, other: tuple[int, int]) -> float:
    """Share of the power of a candidate of a structure that another one, at a grid point, can make [1].

    Beside what every structure has.
    """
    columns, mean = _made(space, structure, c)
    return 1.0 - share_apart(space.gram, columns, mean, [space.candidates[other[0]].columns[other[1]]]) ** 2


def _made(space: Space, structure: Structure, c: int) -> tuple[Indices, Array]:
    """Columns and coefficients of a candidate of a structure (k,)."""
    own = space.estimate(structure)
    columns = space.candidates[c].columns[dict(structure)[c]]
    place = {int(k): value for k, value in zip(own.columns, own.mean, strict=True)}
    return columns, np.array([place[int(k)] for k in columns])
