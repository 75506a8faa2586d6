"""Which of several laws that the equations can hardly tell apart stands in the model: the one that windows prefer."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from flexdyn.diagnose.inference.passes import Posterior
from flexdyn.diagnose.inference.scan import Scan
from flexdyn.diagnose.inference.space import Structure
from flexdyn.diagnose.shooting.windows import Windows
from flexdyn.diagnose.simulated.reweighting import COMPARED_SECONDS, MUCH_NEARER
from flexdyn.diagnose.simulated.structures import LARGEST_QUESTIONED, Simulated
from flexdyn.diagnose.simulated.window_fit import unlike_noise


@dataclass(frozen=True, eq=False)
class Preferred:
    """What windows say of laws that share a name.

    Attributes:
        best: the best structure, with the laws that windows prefer.
        rejected: candidates that windows reject in the place of every name that they share: the least log odds of
            what is preferred there.
    """

    best: Structure
    rejected: Mapping[int, float]


def preferred_by_windows(found: Posterior, rivals: Mapping[int, Sequence[int]], windows: Windows) -> Preferred:
    """The best structure, with those rivals in the place of its candidates that make simulated windows more likely.

    Equations mask the rows near reversals, and there friction of a motor and of its link differ most, as dry friction
    does from one that yields. What has no name is left out of the comparison, as it is left out of the corrected model.
    Of a large structure no numbers are fitted to windows, and nothing is rejected.

    Args:
        found: the posterior over structures.
        rivals: by candidate that has a name, those that share it.
        windows: of the data of the fit.
    """
    simulated, scan = Simulated(found, windows.lasting(COMPARED_SECONDS)), Scan(found.space)
    best, here = found.best, frozenset(each for each in found.best if each[0] in rivals)
    rejecting: dict[int, list[float]] = {}
    for candidate, others in rivals.items():
        mine = next((each for each in here if each[0] == candidate), None)
        if mine is None or not others:
            continue
        rest, additions = here - {mine}, scan.additions(best - {mine})
        points = [mine, *(point for other in others for _, point in additions if point[0] == other)]
        likeliest, odds = _compared(simulated, [rest | {point} for point in points])
        for point in points:
            rejecting.setdefault(point[0], []).append(odds.get(rest | {point}, 0.0))
        preferred = next(point for point in points if rest | {point} == likeliest)
        best, here = best - {mine} | {preferred}, likeliest
    return Preferred(best, {c: min(each) for c, each in rejecting.items() if min(each) > 0.0})


def _compared(simulated: Simulated, structures: Sequence[Structure]) -> tuple[Structure, dict[Structure, float]]:
    """The preferred one of some structures, and its log odds to those that windows reject.

    Where the windows of the first one are at noise it is preferred: the level of the noise is not known well enough for
    their likelihoods. A structure is rejected if its windows are unlike noise with numbers that suit them.
    """
    first, *others = structures
    for each in structures:
        simulated.start(each)
        if each in simulated.fits and len(each) <= LARGEST_QUESTIONED and unlike_noise(simulated.fits[each].shot):
            simulated.fit(each)
    if first not in simulated.fits:
        return first, {}
    here = first
    for each in others:
        if each in simulated.fits and unlike_noise(simulated.fits[here].shot) and simulated.is_worthwhile(each, here):
            here = each
    known = simulated.known
    odds = {each: known[here] - known[each] for each in structures if each in simulated.fitted}
    return here, {
        each: gain
        for each, gain in odds.items()
        if unlike_noise(simulated.fits[each].shot) and gain > _much_nearer(simulated, here, each)
    }


def _much_nearer(simulated: Simulated, here: Structure, there: Structure) -> float:
    """Log odds from which the windows of a structure are much nearer to noise than those of another one."""
    return max(simulated.fits[here].worthwhile, MUCH_NEARER * simulated.fits[there].shot.above_noise)
