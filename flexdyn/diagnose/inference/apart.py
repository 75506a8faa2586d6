"""Effects that stand out of what is left unexplained: one no larger than that cannot be told from it."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from flexdyn.diagnose.inference.space import Space, Structure
from flexdyn.diagnose.inference.unmodelled import Unmodelled

Array = NDArray[np.float64]
LARGER = 1.0
"""Power of an effect's own part over that of what is left at its joint, from which it stands out [1]."""


def standing_out(space: Space, structure: Structure) -> Structure:
    """The structure without effects that are no larger than what is left at their joints.

    An effect's own part is what no other effect of the structure, no number of the file and no plainer law that it
    contains can do. What is left is
    the residual beyond the sensors' noise, unmodelled torques included: they are not explained, only described.
    """
    chosen = sorted(structure)
    named = [each for each in chosen if not isinstance(space.candidates[each[0]].proposal, Unmodelled)]
    whole = space.gram.whole(space.columns(structure))
    value = dict(zip(whole.columns.tolist(), whole.mean.tolist(), strict=True))
    smooth = [k for each in chosen if each not in named for k in space.candidates[each[0]].columns[each[1]].tolist()]
    kept = [k for k in whole.columns.tolist() if k not in set(smooth)]
    left = space.rows + space.raw[:, kept] @ np.array([value[k] for k in kept])
    many = len(space.library.equations.kinds)
    valid = ~space.library.mask
    excess = ((left**2 - 1.0) * valid).reshape(-1, many).sum(axis=0)
    numbers = space.library.numbers.shape[1]
    found = set(structure) - set(named)
    for each in named:
        if space.candidates[each[0]].number is not None:  # its tolerance says how large it must be
            found.add(each)
            continue
        own = _own_part(space, named, each, value, numbers)
        power = (own**2 * valid).reshape(-1, many).sum(axis=0)
        if power.sum() >= LARGER * float(np.maximum(excess, 0.0)[power > 0.01 * power.max()].sum()):
            found.add(each)
    return frozenset(found)


def _own_part(
    space: Space, named: list[tuple[int, int]], each: tuple[int, int], value: dict[int, float], numbers: int
) -> Array:
    """What an effect does that all others, and the file's numbers, cannot do (rows,)."""
    mine = space.candidates[each[0]].columns[each[1]]
    others = [k for other in named if other != each for k in space.candidates[other[0]].columns[other[1]].tolist()]
    scale = 1.0 / np.sqrt(space.prior.precision)
    plain = [k for c in space.contained[each[0]] for k in space.candidates[c].columns[0].tolist()]
    columns = [*range(numbers), *others, *plain]
    X = space.raw[:, columns] * scale[columns]
    does = space.raw[:, mine] @ np.array([value[int(k)] for k in mine])
    G = X.T @ X
    G[np.diag_indices_from(G)] += 1.0  # the priors: a number within its tolerance cannot do more
    return np.asarray(does - X @ np.linalg.solve(G, X.T @ does))
