"""Which of several laws that the equations can hardly tell apart stands in the model: the one that windows prefer."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from flexdyn.diagnose.inference.passes import Posterior
from flexdyn.diagnose.inference.scan import Scan
from flexdyn.diagnose.inference.space import Structure
from flexdyn.diagnose.shooting.windows import Windows
from flexdyn.diagnose.simulated.reweighting import COMPARED_SECONDS
from flexdyn.diagnose.simulated.structures import Simulated


def preferred_by_windows(found: Posterior, rivals: Mapping[int, Sequence[int]], windows: Windows) -> Structure:
    """The best structure, with those rivals in the place of its candidates that make simulated windows more likely.

    Equations mask the rows near reversals, and there dry friction and one that yields differ most. What has no name is
    left out of the comparison, as it is left out of the corrected model.

    Args:
        found: the posterior over structures.
        rivals: by candidate that has a name, those that share it.
        windows: of the data of the fit.
    """
    simulated, scan = Simulated(found, windows.lasting(COMPARED_SECONDS)), Scan(found.space)
    best, here = found.best, frozenset(each for each in found.best if each[0] in rivals)
    simulated.start(here)
    for candidate, others in rivals.items():
        mine = next((each for each in here if each[0] == candidate), None)
        additions = scan.additions(best - {mine}) if mine and others else []
        for other in others:
            point = next((point for _, point in additions if point[0] == other), None)
            if mine is None or point is None or here not in simulated.fits:
                continue
            there = here - {mine} | {point}
            simulated.start(there)
            if there in simulated.fits and simulated.is_worthwhile(there, here):
                best, here, mine = best - {mine} | {point}, there, point
    return best
