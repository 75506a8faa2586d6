"""Where to begin: nothing, or the same effect on every joint, each under the model error that it leaves itself."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from flexdyn.diagnose.inference.discrepancy import Discrepancy
from flexdyn.diagnose.inference.gram import Gram, Prior
from flexdyn.diagnose.inference.space import Space, Structure

Array = NDArray[np.float64]
TRIED = 3
"""Groups that are compared under their own model error in a step: those of most evidence under the present one."""


def evidence(space: Space, structure: Structure, runs: NDArray[np.intp]) -> float:
    """Log evidence and prior of a structure under the model error that it leaves, log-determinant included."""
    noise = Discrepancy.of(space.left(structure), runs)
    columns = np.concatenate([np.arange(space.base), space.columns(structure)]).astype(np.intp)
    white = noise.innovations(space.raw[:, columns])
    y = -noise.innovations(space.rows[:, None])[:, 0]
    prior = Prior(*(each[columns] for each in (space.prior.precision, space.prior.mean, space.prior.positive)))
    gram = Gram(white, y, prior, space.base, len(columns))
    own = gram.estimate(np.arange(space.base, len(columns)))
    return own.log_likelihood + space.log_prior(structure) + space.log_large(structure, own) - noise.log_scale


def begun(space: Space, start: Structure, runs: NDArray[np.intp]) -> Structure:
    """The start with effects that are on every joint, as long as each such group adds to the evidence."""
    here, best = start, evidence(space, start, runs)
    groups = _groups(space)
    while True:
        open_ = [here | group for group in groups if not {c for c, _ in group} & {c for c, _ in here}]
        ranked = sorted(open_, key=lambda s: (-space.value(s), sorted(s)))[:TRIED]
        scored = [(evidence(space, each, runs), each) for each in ranked]
        if not scored or max(scored, key=lambda pair: pair[0])[0] <= best:
            return here
        best, here = max(scored, key=lambda pair: pair[0])
        space.under(Discrepancy.of(space.left(here), runs))


def _groups(space: Space) -> list[Structure]:
    """The same effect without nonlinear parameters on every joint, motor side by motor side or link by link."""
    joints = set(space.library.equations.true.joint_names)
    found: dict[tuple[str, str | None], dict[str, int]] = {}
    for c, each in enumerate(space.candidates):
        if each.proposal is not None and len(each.proposal.grid) == 1 and not each.proposal.fixed and each.width == 1:
            if "joint" in each.place and "other" not in each.place:
                found.setdefault((each.kind, each.place.get("side")), {})[each.place["joint"]] = c
    return [frozenset((c, 0) for c in group.values()) for group in found.values() if set(group) == joints]
