"""Whether a fit sees what is named: how far sizes must be from nothing."""

from __future__ import annotations

import math

from scipy.special import ndtri

from flexdyn.diagnose.constants import ESTABLISHED
from flexdyn.diagnose.decision.model_effects import without_effect
from flexdyn.diagnose.hypothesis.estimate import fit
from flexdyn.diagnose.hypothesis.fitted import Fit
from flexdyn.diagnose.inference.candidate import Candidate
from flexdyn.diagnose.inference.space import Space
from flexdyn.diagnose.inference.structure_model import effect_of
from flexdyn.effects import Effect


def stays(space: Space, c: int, made: Fit, smallest: float) -> bool:
    """Whether the fitted effect of a candidate is seen, and at least as large as an effect must be.

    Fits to windows have errors of their own where friction holds. So the equations must see a number of the file, too.

    Args:
        space: that has the candidate.
        c: the candidate.
        made: the fit.
        smallest: share of torque that an effect must make.
    """
    candidate, log_odds = space.candidates[c], space.places.log_odds(c)
    if not is_significant(candidate, made, log_odds):
        return False
    if candidate.number is not None:
        return not made.block or is_significant(candidate, fit(made.hypothesis, made.space), log_odds)
    here, effect = made.hypothesis, effect_of(candidate, made.hypothesis)
    if effect is None:
        return False
    change = made.equations.residual - made.equations.of(without_effect(here, effect).model()).residual
    share, least = space.library.sizes.of(effect, change, smallest)
    return share >= least


def is_significant(candidate: Candidate, made: Fit, log_odds: float) -> bool:
    """Whether a fit tells a candidate from nothing, and a number of the file from its tolerance.

    Args:
        candidate: of the structure.
        made: the fit.
        log_odds: prior log odds that the candidate is there.
    """
    number, least = candidate.number, least_deviation(log_odds)
    if number is not None:
        off = abs(made.hypothesis.factors[number] - 1.0) - number.tolerance
        return off >= least * made.factor_std()[number]
    effect = effect_of(candidate, made.hypothesis)
    known = set(made.hypothesis.unknowns())
    sizes = {} if effect is None else {(effect, k): getattr(effect, k) - x for k, x in effect.neutral.items()}
    changes = {key: change for key, change in sizes.items() if key in known}
    if not changes or made.deviation(changes) >= least:
        return True
    return not made.block and _missed_by(made, effect) >= least * made.widened(changes)


def _missed_by(made: Fit, effect: Effect | None) -> float:
    """Root of the rise of chi^2 when a fit to the equations does without an effect [1].

    For a law that is linear in its numbers it is the deviation. The stiffness and the damping of an end stop that is
    hardly touched may be many times larger, but not nothing: their standard deviations say nothing of a missing stop
    (Hauck and Donner, J. Am. Stat. Assoc. 72, 1977).
    """
    without = fit(without_effect(made.hypothesis, effect), made.space)
    return math.sqrt(max(without.reached - made.reached, 0.0))


def least_deviation(log_odds: float) -> float:
    """Standard deviations by which the size of an established name differs from nothing.

    A deviation of z has a Bayes factor of ``exp(z^2/2)`` at most, whatever the prior of the size (Edwards, Lindman and
    Savage, 1963). With the prior odds of the place it must reach the odds of an established name. Where these are high
    enough without data, the probability by the standard deviation alone must be that of an established name.

    Args:
        log_odds: prior log odds that there is such an effect.
    """
    wanted = math.log(ESTABLISHED / (1.0 - ESTABLISHED)) - log_odds
    return max(float(ndtri(ESTABLISHED)), math.sqrt(2.0 * max(wanted, 0.0)))
