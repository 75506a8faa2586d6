"""Whether an effect is what its name says, or an imitation of something that the catalogue lacks.

What is left unexplained shows that something without a name is there. The nearest law of the catalogue takes some
share of it, and then stands out of the rest. With R the power of an effect's own part over that of what is left, an
imitation takes a share 1/(1 + 1/R) of what it imitates. If all shares are equally likely, one as large or larger has
the probability 1/(1 + R). With prior odds c that a drive has the effect rather than something unknown that looks like
it,

    p(genuine) = c (1 + R) / (1 + c (1 + R))
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from flexdyn.diagnose.inference.space import Space, Structure

Array = NDArray[np.float64]
EVERYWHERE, OFTEN, SELDOM = 100.0, 20.0, 1.0
"""Prior odds of an effect to something unknown that looks like it: what every drive has, what most have, the rest."""
COMMON = {
    "viscous_friction": EVERYWHERE,
    "coulomb_friction": EVERYWHERE,
    "stribeck_friction": OFTEN,
    "asymmetric_friction": OFTEN,
    "load_dependent_friction": OFTEN,
    "joint_coupling": OFTEN,
    "joint_elasticity": OFTEN,
    "channel_lag": OFTEN,
    "command_delay": OFTEN,
    "rotor_inertia": OFTEN,
}


def genuine(kind: str, share: float) -> float:
    """Probability that an effect is what its name says.

    Args:
        kind: of the effect.
        share: power of its own part over that of what is left [1].
    """
    odds = COMMON.get(kind, SELDOM) * (1.0 + min(share, 1e12))
    return odds / (1.0 + odds)


def shares(space: Space, structure: Structure) -> dict[int, float]:
    """Of every effect of a structure: power of its own part over that of what is not explained [1].

    An effect's own part is what no other effect of the structure, no number of the file and no plainer law that it
    contains can do. What is not explained is the residual beyond the sensors' noise at the same equations.
    """
    columns, mean = space.gram.with_base(space.gram.estimate(space.columns(structure)))
    value = dict(zip(columns.tolist(), mean.tolist(), strict=True))
    squares = np.array([each.squares(columns, mean) for each in space.equations])
    excess = np.maximum(squares - space.seen.count, 0.0)
    found = {}
    for each in sorted(structure):
        power = _own_power(space, structure, each, value)
        found[each[0]] = float(power.sum()) / max(float(excess[power > 0.01 * power.max()].sum()), 1e-300)
    return found


def _own_power(space: Space, structure: Structure, each: tuple[int, int], value: dict[int, float]) -> Array:
    """Squares of what an effect does that all others, and the file's numbers, cannot do (equations,)."""
    numbers = space.library.numbers.shape[1]
    mine = space.candidates[each[0]].columns[each[1]]
    if space.candidates[each[0]].number is not None:  # its column within the tolerance, and that of what is beyond
        mine = np.array([each[0], *mine], np.intp)
    others = [k for other in structure if other != each for k in space.candidates[other[0]].columns[other[1]].tolist()]
    plain = [k for c in space.contained[each[0]] for k in space.candidates[c].columns[0].tolist()]
    columns = np.setdiff1d(np.array([*range(numbers), *others, *plain], np.intp), mine)
    does = np.array([value[int(k)] for k in mine])
    rows = np.stack([equation.sum(mine, does) for equation in space.equations], axis=1)
    scale = 1.0 / np.sqrt(space.prior.precision[columns])
    # The priors stand beside the rows, each with the weight of its equation: a number in its tolerance does no more.
    tables = [np.zeros((len(rows), len(columns))) for _ in space.equations]
    for table, equation in zip(tables, space.equations, strict=True):
        there = equation.place[columns]
        table[:, there >= 0] = equation.X[:, there[there >= 0]] * scale[there >= 0]
    weights = space.gram.weights
    G = sum((w * table.T @ table for w, table in zip(weights, tables, strict=True)), np.eye(len(columns)))
    b = sum((w * table.T @ y for w, table, y in zip(weights, tables, rows.T, strict=True)), np.zeros(len(columns)))
    best = np.linalg.solve(G, b)
    return np.array([((y - table @ best) ** 2).sum() for table, y in zip(tables, rows.T, strict=True)])
