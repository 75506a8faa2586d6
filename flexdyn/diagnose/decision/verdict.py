"""The verdict: whether noise is left on the test data, and whether effects were named."""

from __future__ import annotations

from collections.abc import Sequence

from flexdyn.diagnose.decision.gaps import Shots
from flexdyn.diagnose.report.measures import Left
from flexdyn.diagnose.report.result import Verdict


def is_noise(shots: Shots | None, left: Sequence[Left]) -> bool:
    """Whether what is left on the test data is noise.

    The gap of the median window is that of a perfect model, and no joint's equations leave more than 1 % of its torque.
    The median is used because a single window with wrong sticking has little meaning.

    Args:
        shots: windows; None: the data are too short for one, and the equations alone tell.
        left: what the equations of the corrected model leave, joints with 1 % of their torque or more.
    """
    if shots is None:
        return not left
    return shots.after.is_noise(shots.gap.floor) and not left


def verdict(*, named: bool, noise: bool, converged: bool) -> Verdict:
    """What the report says.

    Args:
        named: whether there are findings; all of them are established.
        noise: whether what is left is noise.
        converged: whether the final fit stands at a stationary point.
    """
    if not converged:
        return "not_converged"
    if noise:
        return "explained" if named else "no_discrepancy"
    return "partly_explained" if named else "unexplained"
