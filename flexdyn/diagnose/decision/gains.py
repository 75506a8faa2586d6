"""Share of the gap on the test data that each name removes."""

from __future__ import annotations

import itertools
import math
from collections.abc import Mapping, Sequence

from flexdyn.diagnose.decision.corrected import Corrected
from flexdyn.diagnose.decision.model_rows import ModelRows
from flexdyn.diagnose.decision.naming import Name
from flexdyn.diagnose.report.measures import Shares


def gains(rows: ModelRows, found: Corrected, named: Sequence[Name]) -> dict[int, float]:
    """Share of the gap on the test data that each name removes, at most 1; NaN where all rows are masked.

    The residual of the equations is used, because windows would have to be simulated again for every name. A name is
    left out of the corrected model with all other numbers as they are. So the shares of effects that could replace one
    another add up to more than 1.

    Args:
        rows: over the test data.
        found: the corrected model.
        named: the names that are reported.
    """
    _, before, after = map(rows.size, rows.models)
    whole = max(before - min(after, 1.0), 1e-9)
    without = {c: rows.of_hypothesis(found.without(c)) for c in (each.candidate for each in named)}
    gain = {c: (rows.size(at) - after) / whole for c, at in without.items()}
    return {c: min(1.0, each) if math.isfinite(before - after) else math.nan for c, each in gain.items()}


def shares_of_gap(rows: ModelRows, found: Corrected, named: Sequence[Name], gain: Mapping[int, float]) -> Shares | None:
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
    steps = (rows.of_hypothesis(found.without(*order[k:])) for k in range(len(order)))
    power = [float((rows.white(at)[rows.seen] ** 2).sum()) for at in (rows.given, *steps, rows.after)]
    count = int(rows.seen.sum())
    if not count or not power[0] > 0.0:
        return None
    gone = [(one - other) / power[0] for one, other in itertools.pairwise(power)]
    return Shares(gone[0], tuple(gone[1:]), power[-1] / power[0], count / power[0])


def in_order(candidates: Sequence[int], gain: Mapping[int, float]) -> list[int]:
    """Candidates in the order of the report: the one that explains most first."""
    known = {c: gain.get(c, math.nan) for c in candidates}
    return sorted(candidates, key=lambda c: -known[c] if math.isfinite(known[c]) else 0.0)
