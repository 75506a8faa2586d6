"""Pictures of what the model left unexplained, before and after: those that tell most."""

from __future__ import annotations

import numpy as np

from flexdyn.diagnose.equations.covariance import Whitener
from flexdyn.diagnose.equations.equations import Equations
from flexdyn.diagnose.equations.localise import traces
from flexdyn.diagnose.report.trace import Trace

EQUATIONS = 3
"""Equations that are drawn, each over time and over what its residual depends on more."""


def drawn(before: Equations, after: Equations, whiten: Whitener) -> tuple[Trace, ...]:
    """The equations of which the correction takes most, in units of noise; of each two pictures.

    Args:
        before: of the model as given.
        after: of the corrected model, over the same recordings.
        whiten: by the sensors' noise.
    """
    powers = [(whiten(at.residual).reshape(-1, len(at.kinds)) ** 2).sum(axis=0) for at in (before, after)]
    order = np.argsort(powers[1] - powers[0], kind="stable")
    pictures = traces(before, after, whiten.mask)
    found: list[Trace] = []
    for k in order[:EQUATIONS].tolist():
        over_time, *clouds = pictures[3 * k : 3 * k + 3]
        found += [over_time, max(clouds, key=_dependence)]
    return tuple(found)


def _dependence(cloud: Trace) -> float:
    """Spread of the averages over neighbours: what the residual changes with."""
    spread = float(np.nanvar(cloud.means[:, 1])) if len(cloud.means) else 0.0
    return spread if np.isfinite(spread) else 0.0
