"""Pictures of what the model left unexplained, before and after: those that tell most."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from flexdyn.diagnose.answer.trace import Trace
from flexdyn.diagnose.covariance import Whitener
from flexdyn.diagnose.equations import Equations
from flexdyn.diagnose.localise import traces

Array = NDArray[np.float64]
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
    found = []
    for k in order[:EQUATIONS].tolist():
        over_time, *clouds = pictures[3 * k : 3 * k + 3]
        found += [over_time, max(clouds, key=_dependence)]
    return tuple(
        Trace(each.title, each.x_label, each.y_label, each.x, each.before, each.after, each.means) for each in found
    )


def _dependence(cloud: object) -> float:
    """Spread of the averages over neighbours: what the residual changes with."""
    means = np.asarray(getattr(cloud, "means", np.zeros((0, 3))))
    spread = float(np.nanvar(means[:, 1])) if len(means) else 0.0
    return spread if np.isfinite(spread) else 0.0
