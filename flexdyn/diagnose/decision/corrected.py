"""The corrected model: what is named and the file's numbers, fitted, and no more."""

from __future__ import annotations

import dataclasses
import functools
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from flexdyn.arrays import Array
from flexdyn.diagnose.constants import ESTABLISHED, LEAST_IN_COMMON, SMALLEST_TORQUE_SHARE
from flexdyn.diagnose.decision.calibrated import within
from flexdyn.diagnose.decision.even_odds import told_by_data
from flexdyn.diagnose.decision.last_fit import (
    Refit,
    continued,
    converged,
    fit_of_kept,
    leaves_noise,
    no_stiffer_than_seen,
    to_equations,
)
from flexdyn.diagnose.decision.masses import Masses
from flexdyn.diagnose.decision.model_effects import possible
from flexdyn.diagnose.decision.naming import Name, names, standing_in
from flexdyn.diagnose.decision.one_law import completing
from flexdyn.diagnose.decision.significance import stays
from flexdyn.diagnose.hypothesis.fitted import Fit
from flexdyn.diagnose.hypothesis.hypothesis import Hypothesis
from flexdyn.diagnose.hypothesis.less_rounded import less_rounded
from flexdyn.diagnose.hypothesis.workspace import Workspace
from flexdyn.diagnose.inference.apart import genuine, power_ratios
from flexdyn.diagnose.inference.candidate import Candidate
from flexdyn.diagnose.inference.passes import Posterior
from flexdyn.diagnose.inference.posterior_of_fit import squares_left
from flexdyn.diagnose.inference.space import Space
from flexdyn.diagnose.inference.structure_model import effect_of, hypothesis_of
from flexdyn.diagnose.inference.substitutes import in_common, own_share
from flexdyn.effects import Effect

Share = Callable[[int], float]
Judges = Literal["either", "both", "windows"]


@dataclass(frozen=True, eq=False)
class Corrected:
    """The names, and the model that has them.

    Attributes:
        fitted: the corrected model.
        names: established ones, effects and numbers of the file, in the order of their candidates.
        masses: of all sets of candidates.
        space: that compared them.
        explained: whether the equations of the fit leave no more than noise.
        genuine: by candidate, probability that it is no imitation of something that the catalogue lacks [1].
    """

    fitted: Fit
    names: tuple[Name, ...]
    masses: Masses
    space: Space
    explained: bool
    genuine: dict[int, float]

    @property
    def hypothesis(self) -> Hypothesis:
        """The corrected model's numbers and effects."""
        return self.fitted.hypothesis

    @property
    def named(self) -> frozenset[int]:
        """Candidates that have names."""
        return frozenset(each.candidate for each in self.names)

    @property
    def joints(self) -> tuple[str, ...]:
        """Of the model."""
        return tuple(self.hypothesis.given.joint_names)

    def effect(self, candidate: int) -> Effect | None:
        """The corrected model's effect of a candidate; None: it has none."""
        return effect_of(self.candidates[candidate], self.hypothesis)

    def without(self, *candidates: int) -> Hypothesis:
        """The corrected model without some of its names, all other numbers as they are."""
        here, numbers = self.hypothesis, {self.candidates[c].number for c in candidates}
        gone = [self.effect(c) for c in candidates]
        kept = [each for each in here.effects if not any(each is other for other in gone)]
        factors = {number: 1.0 if number in numbers else factor for number, factor in here.factors.items()}
        return dataclasses.replace(here, factors=factors, freed=here.freed - numbers, effects=possible(here, kept))

    def instead(self, rival: int, of: int) -> Hypothesis | None:
        """The most probable structure with a rival in the place of a candidate, by the linear equations."""
        place = self.masses.place([rival], [of])
        if place is None:
            return None
        return hypothesis_of(self.space, self.masses.structures[place], whole=True)

    @property
    def candidates(self) -> Sequence[Candidate]:
        """All that were compared."""
        return self.space.candidates

    @property
    def converged(self) -> bool:
        """Whether the fit has converged to a stationary point."""
        return converged(self.fitted)


def corrected(
    found: Posterior,
    plain: Workspace,
    simulated_share: Share | None = None,
    *,
    judges: Judges = "either",
    refit: Refit = to_equations,
) -> Corrected:
    """Name what is established, and fit the model with these names and no others.

    For an "A or B" the model contains A, and what B has beyond it where that is certain. If more than noise is left,
    something without a name may have displaced the file's numbers: they are kept within their tolerance.

    Args:
        found: the posterior over structures.
        plain: the equations of the model as given, with the sensors' weights.
        simulated_share: own part of a candidate in simulations over what is left there, where the linear equations do
            not make it stand out [1]; None: they alone decide.
        judges: in which of equations and simulations a name must stand out: in both where simulations reject the
            structure, in windows alone where they and not the equations have found it.
        refit: fits what is left where a part without a name goes.
    """
    space, here = found.space, found.fitted.hypothesis
    masses = _masses(found)
    best = frozenset(c for c, _ in found.best)
    there = [c for c in sorted(best) if is_there(space.candidates[c], here)]
    apart = functools.partial(power_ratios, space, overstated=_overstated(found))
    own = _genuine(found, apart(found.best))
    may = functools.partial(_may_stand_in, found, masses)
    sure = [each.candidate for each in names(masses, best, None, there, may) if each.established]
    simulated = {c: simulated_share(c) for c in sure} if simulated_share else {}
    seen = _genuine(found, simulated)

    def weighed() -> dict[int, float]:
        """Probabilities that a name is genuine, by the equations and, where there are any, by simulations."""
        judged = {c: (each, seen.get(c, each)) for c, each in own.items()}
        if judges == "windows":
            return {c: by_windows for c, (_, by_windows) in judged.items()}
        return {c: max(each) if judges == "either" else min(each) for c, each in judged.items()}

    completed = functools.partial(completing, space, masses, there=there)
    named = names(masses, best, weighed(), there, may)
    told: set[int] = set()
    real = {c for c in best if own[c] >= ESTABLISHED}  # also where nobody knows which of several laws it is
    while told != (told := {each.candidate for each in named if each.established}):
        # What may be an imitation explains nothing: the names must stand out from it, too.
        certain = told | real | completed([each for each in named if each.established])
        alone = _genuine(found, apart(frozenset(each for each in found.best if each[0] in certain)))
        own |= {c: min(own[c], alone[c]) for c in told}
        named = names(masses, best, weighed(), there, may)
    kept = told_by_data(space, masses, best, [each for each in named if each.established], may)
    made = fit_of_kept(space, found.fitted, {each.candidate for each in kept} | completed(kept), refit)
    # An effect that explains more in simulations than remains there may be small in the equations.
    least = {c: 0.0 if simulated.get(c, 0.0) > 1.0 else SMALLEST_TORQUE_SHARE for c in best}
    # The linear equations may have promised too much; what is left out displaces the others.
    while kept != (kept := tuple(each for each in kept if stays(space, each.candidate, made, least[each.candidate]))):
        made = fit_of_kept(space, made, {each.candidate for each in kept} | completed(kept), refit)
    if not made.block:  # what was fitted to windows stays: the equations may not see it
        made = no_stiffer_than_seen(less_rounded(continued(made)))
    kept = tuple(each for each in kept if is_there(space.candidates[each.candidate], made.hypothesis))
    explained = leaves_noise(made, plain)
    made = made if explained else within(made)
    return Corrected(made, kept, masses, space, explained, weighed())


def _genuine(found: Posterior, share: Mapping[int, float]) -> dict[int, float]:
    """Probability by candidate that it is no imitation, from how far it stands out from what is left."""
    has = found.fitted.hypothesis.given.effects
    return {c: genuine(found.space.candidates[c], each, found.expected, has) for c, each in share.items()}


def _overstated(found: Posterior) -> Array:
    """What the linear equations leave of the best structure, and its fit does not (equations,)."""
    space = found.space
    left, _ = squares_left(found.fitted.equations, found.fitted.space)
    return np.maximum(space.gram.squares(space.estimate(found.best)) - left, 0.0)


def _masses(found: Posterior) -> Masses:
    """Posterior over all sets; where linearisations do not agree, their average, and where fits tell more, by these.

    Something outside the catalogue is explained by another law at every linearisation; an effect that exists is in all
    of them. Of the structures at other linearisations, only effects of the present best structure count, laws that
    contain them or that they contain, and what could take their place here or along the motion. At last, sets with what
    simulated windows reject are less probable by the odds there.
    """
    space, masses = found.space, Masses.of(found.known).without(found.left_out).by_fits(found.by_fits)
    best = frozenset(c for c, _ in found.best)
    alike = best | {c for c, inside in space.contained.items() if best & set(inside)}
    alike |= {each for c in best for each in (*space.contained[c], *standing_in(masses, best, {c}))}
    for other in frozenset().union(*(each for each, _ in found.other_linearisations)) - alike:
        if any(own_share(space, found.best, c, other) <= SMALLEST_TORQUE_SHARE for c in best):
            alike |= {other}
    if found.other_linearisations:
        others, odds = zip(*found.other_linearisations, strict=True)
        masses = masses.mixed([each & alike for each in others], odds)
    return masses.without(found.rejected)


def is_there(candidate: Candidate, here: Hypothesis) -> bool:
    """Whether a candidate that may be named does something in a hypothesis."""
    if candidate.number is not None:
        return candidate.number in here.freed
    effect = effect_of(candidate, here)
    return effect is not None and not effect.is_neutral


def _may_stand_in(found: Posterior, masses: Masses, of: int, c: int) -> bool:
    """Whether a candidate may be reported as a rival of another one, which is in the best structure.

    A rival makes some of what the other one does, beside the file's numbers. One that makes nothing of it stands in the
    place of something else. A number of the file that stays in its tolerance is no rival.
    """
    space = found.space
    place = masses.place([c], [of])
    if place is None:
        return False
    there = masses.structures[place]
    instead = frozenset(k for k, _ in found.best) - {of} | {c}
    fitted = any(frozenset(k for k, _ in each) == instead for each, _, _ in found.by_fits)  # its odds say what it makes
    if not fitted and in_common(space, found.best, of, (c, dict(there)[c])) < LEAST_IN_COMMON:
        return False
    number = space.candidates[c].number
    return number is None or hypothesis_of(space, there).is_beyond(number)
