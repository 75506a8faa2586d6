"""What of the gap on the test data goes with each name."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from flexdyn.diagnose.decision.corrected import Corrected
from flexdyn.diagnose.decision.held_out import HeldOut
from flexdyn.diagnose.decision.naming import Name
from flexdyn.diagnose.hypothesis.hypothesis import Hypothesis


def gains(rows: HeldOut, calibrated: Hypothesis, found: Corrected, named: Sequence[Name]) -> dict[int, float]:
    """Share of the gap on the test data that goes with each name, at most 1.

    Windows would have to be simulated anew for every name; what the equations leave stands for them. A name is left
    out of the corrected model with all other numbers as they are, so shares of effects that could stand in for one
    another add up to more than 1.

    Args:
        rows: over the test data.
        calibrated: the model with the file's numbers alone.
        found: the corrected model.
        named: what is told.
    """

    def off(hypothesis: Hypothesis | None) -> float:
        white = rows.white(hypothesis)[rows.seen]
        return float(np.sqrt((white**2).mean())) if len(white) else np.nan

    after, before = off(None), off(calibrated)
    if not np.isfinite(before - after):  # no row says anything
        return {each.candidate: np.nan for each in named}
    whole = max(before - min(after, 1.0), 1e-9)
    return {each.candidate: min(1.0, (off(found.without(each.candidate)) - after) / whole) for each in named}
