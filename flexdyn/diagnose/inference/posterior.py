"""The posterior over structures, on the equations that see most of those that hold."""

from __future__ import annotations

import dataclasses

from flexdyn.diagnose.hypothesis.estimate import fit
from flexdyn.diagnose.hypothesis.fitted import Fit
from flexdyn.diagnose.hypothesis.hypothesis import Hypothesis
from flexdyn.diagnose.hypothesis.prepared import behind_motors, without_reversals
from flexdyn.diagnose.hypothesis.unweighted import Unweighted
from flexdyn.diagnose.hypothesis.workspace import beginning_as
from flexdyn.diagnose.inference.passes import Posterior, passes
from flexdyn.diagnose.inference.posterior_of_fit import leaves_more_than_noise
from flexdyn.diagnose.inference.weights import for_fit, quieter
from flexdyn.errors import SimulationError

NUMBERS_STEPS = 3
"""Gauss-Newton steps at most of the first fit, of the file's numbers alone."""


def posterior(bare: Unweighted, start: Hypothesis) -> Posterior:
    """Compare structures on the equations.

    Where links are not measured, their positions are computed, as if their gears had no play. Where this explains the
    data except while loads change their signs, those rows are left out: simulated windows will tell what acts there.

    The equations in which such links are simulated behind their motors see more, but are far from linear. So they come
    second: where what was found leaves more than noise in them. They count if what they find leaves noise: else they
    may hold vibrations of another cause.

    Args:
        bare: the equations of the model as given, with the noise that the records show.
        start: the file's numbers where they stand.
    """
    start = dataclasses.replace(start, fits_cycles=True)
    found, whole = _on_computed_positions(bare, start)
    moving = behind_motors(bare, start)
    if moving is None:
        return found
    made = found.fitted.hypothesis
    if whole and not _leaves_something(moving, made):
        return found
    # What does not even explain the first equations holds what computed positions lack: it is no place to begin.
    there = start if leaves_more_than_noise(found.fitted) else made
    if not whole:  # what acts there may be a vibration that computed positions lack, and no play
        explaining = [each for each in (made, start) if not _leaves_something(moving, each)]
        if not explaining:
            return found
        there = explaining[0]
    try:
        seen = passes(moving, dataclasses.replace(there, fits_cycles=True))
    except SimulationError:  # at numbers far from the right ones, links may not be simulated to the end
        return found
    return found if leaves_more_than_noise(seen.fitted) else seen


def _on_computed_positions(bare: Unweighted, start: Hypothesis) -> tuple[Posterior, bool]:
    """Structures compared on the first equations, and whether with the rows in which loads change their signs."""
    between = without_reversals(bare)
    begun, lacking = _from_numbers(bare, start)
    if between is None:
        return passes(bare, begun), True
    begun_between, lacking_between = _from_numbers(between, start)
    if lacking and not lacking_between:  # whatever is missing acts in those rows alone
        return passes(between, begun_between), False
    found = passes(bare, begun)
    other = passes(between, begun_between) if leaves_more_than_noise(found.fitted) else None
    return (found, True) if other is None or leaves_more_than_noise(other.fitted) else (other, False)


def _from_numbers(bare: Unweighted, start: Hypothesis) -> tuple[Hypothesis, bool]:
    """Where the file's numbers alone fit equations best, and whether they leave more than noise there."""
    alone = _numbers_alone(bare, start)
    return _in_tolerance(alone.hypothesis, start), leaves_more_than_noise(alone)


def _leaves_something(bare: Unweighted, there: Hypothesis) -> bool:
    """Whether a hypothesis leaves more than noise in other equations, its numbers fitted to them."""
    try:
        return leaves_more_than_noise(_numbers_alone(beginning_as(bare, there), there))
    except SimulationError:
        return False


def _numbers_alone(bare: Unweighted, start: Hypothesis) -> Fit:
    """A first fit of the file's numbers."""
    at = bare.equations.of(start.model())
    bare = dataclasses.replace(bare, noise=quieter(bare.noise, at, bare.mask))
    return fit(start, for_fit(bare, start), steps=NUMBERS_STEPS)


def _in_tolerance(fitted: Hypothesis, start: Hypothesis) -> Hypothesis:
    """A fit of the file's numbers; where it moves one of them beyond its tolerance, the numbers as they were.

    Such a fit imitates a missing effect. Where stiffnesses and masses stand in for it, the linear equations of the
    effect itself are wrong by products of these changes.
    """
    return fitted if fitted.tolerated().factors == fitted.factors else start
