"""Structures compared by simulated windows, if the equations cannot separate them."""

from __future__ import annotations

import dataclasses
import itertools
from collections.abc import Callable
from dataclasses import dataclass

from flexdyn.diagnose.constants import CERTAIN_SIGMAS, NOISE_LEVEL_ERROR
from flexdyn.diagnose.hypothesis.fitted import Fit
from flexdyn.diagnose.inference.passes import Posterior
from flexdyn.diagnose.inference.space import Structure
from flexdyn.diagnose.shooting.gap import shoot
from flexdyn.diagnose.shooting.windows import Windows
from flexdyn.diagnose.simulated.structures import LARGEST_QUESTIONED, Simulated
from flexdyn.diagnose.simulated.window_fit import WindowFit, fit_to_windows, unlike_noise
from flexdyn.effects import JointEffect
from flexdyn.errors import FlexdynError

COMPARED_SECONDS = 8.0
"""Length of all windows together over which structures are compared, spread evenly [s]: 16 of the usual ones. What is
found is held against all of them."""
MUCH_NEARER = 0.5
"""Share of what separates the windows from noise, in log likelihood, that a structure must gain to take the place of
the one that the equations prefer, where it does not come to noise [1]. Choice."""


@dataclass(frozen=True, eq=False)
class Reweighed:
    """A posterior by simulated windows.

    Attributes:
        found: the posterior.
        explained: whether its best structure brings the windows to noise.
    """

    found: Posterior
    explained: bool


def share_in_windows(simulated: Simulated, candidate: int) -> float:
    """What a candidate of the best structure takes off the windows, over what is left of them [1].

    With the squared gaps of all windows but the farthest ones: ``(without it - with it) / (with it - 1)``; without it,
    the file's numbers stay within three tolerances. Of the noise's power `NOISE_LEVEL_ERROR` is unknown.

    Args:
        simulated: structures over the windows of the data of the fit.
        candidate: of the best structure.
    """
    found, windows = simulated.found, simulated.windows
    rest = frozenset(each for each in found.best if each[0] != candidate)
    simulated.start(found.best)
    if found.best not in simulated.fits:
        return 0.0
    whole = simulated.fits[found.best].shot.left
    try:
        without = shoot(simulated.by_equations(rest).hypothesis.tolerated().seen(), windows).left
    except FlexdynError:
        return 0.0
    return max(without - whole, 0.0) / (max(whole - 1.0, 0.0) + NOISE_LEVEL_ERROR)


def _with_other_numbers(simulated: Simulated, here: WindowFit) -> WindowFit:
    """The best structure with numbers that suit all windows, where those that suit some of them come to noise there."""
    best = simulated.found.best
    simulated.fit(best)
    if best not in simulated.fitted or unlike_noise(simulated.fits[best].shot):
        return here
    return fit_to_windows(WindowFit.of(simulated.fits[best].made, here.shot.windows))


def _is_certain(simulated: Simulated, best: Structure) -> bool:
    """Whether windows are certain of what a law of a structure has beyond a plainer one that the equations have there.

    Without it the two are the same, but for when a joint sticks, which noise decides: the more flexible law then fits
    better, whatever the robot has.
    """
    candidates, made = simulated.found.space.candidates, simulated.fits[best].made
    for law, plain in itertools.product(*([candidates[c] for c, _ in each] for each in (best, simulated.found.best))):
        if plain.kind not in law.law.contains or plain.spot != law.spot:
            continue
        common = {each.name for each in plain.law.parameters()}
        unsure = [
            not abs(getattr(effect, name)) > CERTAIN_SIGMAS * sigma
            for (effect, name), sigma in made.std().items()
            if isinstance(effect, JointEffect)
            and (effect.name, effect.joint, effect.side) == (law.kind, *law.spot)
            and name not in common
        ]
        if unsure and all(unsure):
            return False
    return True


def reweighed(
    found: Posterior, windows: Windows, fits: Callable[[Fit], bool], *, all_named: bool = True
) -> Reweighed | None:
    """The posterior with the numbers, and if needed the structures, that fit simulated windows.

    Where numbers in their tolerance bring the windows of the best structure to noise, and the equations too, structures
    stay as the equations have them, if all of the best one has names: a part without a name may be what the windows
    lack. Else its neighbours are simulated, and theirs. What comes to noise in the end takes its place, and the
    structures that were simulated are weighed by their windows. Where only a few windows are off, all of them must come
    to noise together. What does not come to noise, but much nearer to it, takes its place too, and is no full
    explanation.

    A structure of more than `LARGEST_QUESTIONED` candidates is not searched.

    Args:
        found: by the equations.
        windows: of the data of the fit.
        fits: whether a fit's equations leave noise alone.
        all_named: whether the best structure holds nothing without a name.

    Returns:
        None where nothing brings the windows much nearer to noise.
    """
    here = first = WindowFit.of(found.fitted, windows)
    few = here.shot.is_noise()  # what is missing shows in a few windows alone, as wrong sticking does
    simulated = Simulated(found, windows.lasting(COMPARED_SECONDS))
    if unlike_noise(here.shot):
        here = _with_other_numbers(simulated, here)
    large = len(found.best) > LARGEST_QUESTIONED
    if (all_named or large) and here.explains and fits(here.made):
        return Reweighed(dataclasses.replace(found, fitted=fit_to_windows(here).made), True)
    if large:
        return None
    best = simulated.climbed(found.best)
    if best not in simulated.fits or not _is_certain(simulated, best):
        return None
    if best != found.best:
        here = fit_to_windows(WindowFit.of(simulated.fits[best].made, windows))
    explained = here.shot.is_noise() and not (few and unlike_noise(here.shot))
    if not explained and here.log_posterior < first.log_posterior + max(
        first.worthwhile, MUCH_NEARER * first.shot.above_noise
    ):
        return None
    # The windows have decided between what the linearisations did not agree about.
    by_windows = dataclasses.replace(
        found,
        best=best,
        fitted=here.made,
        known=simulated.known,
        earlier=(),
        by_fits=(),
        left_out={},
        rejected={},
    )
    return Reweighed(by_windows, explained)
