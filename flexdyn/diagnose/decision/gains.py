"""Share of the gap on the test data that each name removes."""

from __future__ import annotations

import itertools
import math
from collections.abc import Mapping, Sequence

import numpy as np

from flexdyn.diagnose.decision.corrected import Corrected
from flexdyn.diagnose.decision.held_out import HeldOut
from flexdyn.diagnose.decision.naming import Name
from flexdyn.diagnose.hypothesis.hypothesis import Hypothesis
from flexdyn.diagnose.report.measures import Shares


def gains(rows: HeldOut, calibrated: Hypothesis, found: Corrected, named: Sequence[Name]) -> dict[int, float]:
    """Share of the gap on the test data that each name removes, at most 1.

    The residual of the equations is used, because windows would have to be simulated again for every name. A name is
    left out of the corrected model with all other numbers as they are. So the shares of effects that could replace one
    another add up to more than 1.

    Args:
        rows: over the test data.
        calibrated: the model with the file's numbers alone.
        found: the corrected model.
        named: the names that are reported.
    """

    def off(hypothesis: Hypothesis | None) -> float:
        white = rows.white(hypothesis)[rows.seen]
        return float(np.sqrt((white**2).mean())) if len(white) else np.nan

    after, before = off(None), off(calibrated)
    if not np.isfinite(before - after):  # all rows are masked
        return {each.candidate: np.nan for each in named}
    whole = max(before - min(after, 1.0), 1e-9)
    return {each.candidate: min(1.0, (off(found.without(each.candidate)) - after) / whole) for each in named}


def shares(rows: HeldOut, found: Corrected, named: Sequence[Name], gain: Mapping[int, float]) -> Shares | None:
    """Shares of the gap on the test data that add up: names are added one after the other, in the order of their gain.

    Args:
        rows: over the test data.
        found: the corrected model.
        named: the names that are reported.
        gain: by candidate, see `gains`.

    Returns:
        None where all rows are masked.
    """
    order = in_order([each.candidate for each in named], gain)
    models = [found.hypothesis.given, *(found.without(*order[k:]).seen() for k in range(len(order) + 1))]
    power = []
    for model in models:
        white = rows.whiten(rows.given.of(model).residual).reshape(rows.seen.shape)[rows.seen]
        power.append(float((white**2).sum()))
    count = int(rows.seen.sum())
    if not count or not power[0] > 0.0:
        return None
    steps = [(one - other) / power[0] for one, other in itertools.pairwise(power)]
    return Shares(steps[0], tuple(steps[1:]), power[-1] / power[0], count / power[0])


def in_order(candidates: Sequence[int], gain: Mapping[int, float]) -> list[int]:
    """Candidates in the order of the report: the one that explains most first."""
    known = {c: gain.get(c, math.nan) for c in candidates}
    return sorted(candidates, key=lambda c: -known[c] if math.isfinite(known[c]) else 0.0)
