"""The last fit: the corrected model's numbers, and whether they have converged and leave no more than noise."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable, Collection

from flexdyn.diagnose.constants import PROMISED_DROP
from flexdyn.diagnose.decision.model_effects import with_elasticity
from flexdyn.diagnose.decision.model_rows import ModelRows
from flexdyn.diagnose.decision.verdict import left_by_joint
from flexdyn.diagnose.hypothesis.estimate import fit
from flexdyn.diagnose.hypothesis.exact_descent import descended
from flexdyn.diagnose.hypothesis.fitted import Fit
from flexdyn.diagnose.hypothesis.hypothesis import Hypothesis
from flexdyn.diagnose.hypothesis.workspace import Workspace
from flexdyn.diagnose.inference.space import Space
from flexdyn.diagnose.inference.structure_model import effect_of

Refit = Callable[[Fit, Hypothesis], Fit]
"""Fits another hypothesis to the data of a fit: to its equations, or to simulated windows."""
PROMISED_SHARE = 0.005
"""A fit has not converged if its next step would also decrease chi^2 by more than this share [1]."""
CONTINUATIONS = 6
"""Times at most that the fit of the corrected model is continued from where its steps ended."""


def fit_of_kept(space: Space, made: Fit, kept: Collection[int], refit: Refit) -> Fit:
    """The fit with the kept candidates alone.

    Args:
        space: that has the candidates.
        made: the fit with all of them.
        kept: the candidates.
        refit: fits what is left.
    """
    here, own = made.hypothesis, [space.candidates[c] for c in sorted(kept)]
    effects = with_elasticity(here, [each for each in here.effects if any(effect_of(one, here) is each for one in own)])
    freed = frozenset(one.number for one in own if one.number is not None)
    if effects == here.effects and freed == here.freed:
        return made
    return refit(made, dataclasses.replace(here, effects=effects, freed=freed))


def to_equations(made: Fit, here: Hypothesis) -> Fit:
    """Another hypothesis, fitted to the equations of a fit."""
    return fit(here, made.space)


def no_stiffer_than_seen(made: Fit) -> Fit:
    """The fit with springs of rigid joints as stiff as the data allow, and no stiffer.

    A spring that only carries a load, for the friction that takes a share of it, may become stiffer in every step. Its
    compliance is then less than its standard deviation, and gets this one: simulations need few steps, and noise winds
    the spring little.
    """
    spread, changes = made.std(), {}
    for effect in made.hypothesis.effects:
        if not effect.makes_elastic:
            continue
        stiffness = float(getattr(effect, effect.makes_elastic))
        unsure = spread.get((effect, effect.makes_elastic), math.nan) / stiffness**2
        if 1.0 / stiffness < unsure < math.inf:
            changes[effect] = effect.replace(**{effect.makes_elastic: 1.0 / unsure})
    if not changes:
        return made
    effects = tuple(changes.get(each, each) for each in made.hypothesis.effects)
    return fit(dataclasses.replace(made.hypothesis, effects=effects), made.space, steps=1)


def continued(made: Fit) -> Fit:
    """The fit, continued as long as it has not converged and still gains: a corner of a law shortens many steps.

    If it gains nothing more and still promises something, its slopes are wrong: then along differences.
    """
    for _ in range(CONTINUATIONS):
        if made.block or converged(made):
            break
        before, made = made.reached, fit(made.hypothesis, made.space)
        if made.reached > before - PROMISED_DROP:
            break
    return made if made.block or converged(made) else descended(made)


def converged(made: Fit) -> bool:
    """Whether a fit's next step promises nothing that matters."""
    promised = made.reached - made.chi2
    return made.stationary or not (promised > PROMISED_DROP and promised > PROMISED_SHARE * made.chi2)


def leaves_noise(made: Fit, plain: Workspace) -> bool:
    """Whether no joint's equations leave more than noise and 1 % of its torque, apart from offsets of the encoders."""
    at = plain.equations.of(made.hypothesis.seen())
    models = (plain.equations, at, at)
    return not left_by_joint(ModelRows(models, plain.noise, plain.whiten), {})
