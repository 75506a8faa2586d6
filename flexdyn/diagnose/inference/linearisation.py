"""What structures are compared on: candidates and weights near a hypothesis; and the fits that begin there."""

from __future__ import annotations

import dataclasses
import math
from dataclasses import dataclass

import numpy as np

from flexdyn.diagnose.constants import OCCAM_WINDOW, WHOLE_NUMBER_LOG_ODDS
from flexdyn.diagnose.hypothesis.estimate import SHORTENED_STEP, fit
from flexdyn.diagnose.hypothesis.fitted import Fit
from flexdyn.diagnose.hypothesis.hypothesis import Hypothesis
from flexdyn.diagnose.hypothesis.linear import require_finite, slopes_of_numbers
from flexdyn.diagnose.hypothesis.proposal import Proposal
from flexdyn.diagnose.hypothesis.unweighted import Unweighted
from flexdyn.diagnose.hypothesis.workspace import Workspace, weighed
from flexdyn.diagnose.inference.autoregression import runs_of
from flexdyn.diagnose.inference.harmonics import with_harmonics
from flexdyn.diagnose.inference.library import Library
from flexdyn.diagnose.inference.memory import check_memory
from flexdyn.diagnose.inference.model_error import ModelError
from flexdyn.diagnose.inference.posterior_of_fit import log_density_at
from flexdyn.diagnose.inference.space import Space, Structure
from flexdyn.diagnose.inference.standing_effects import beliefs
from flexdyn.diagnose.inference.structure_model import hypothesis_of
from flexdyn.diagnose.inference.weights import (
    along_expected,
    error_of,
    expected,
    filter_error,
    for_fit,
    quieter,
    rows_of,
)
from flexdyn.diagnose.lazy import lazy
from flexdyn.errors import SimulationError

WEIGHTINGS, WELL_WEIGHTED = 4, 0.7
"""Largest number of fits of one hypothesis, each weighted by the last residual; they end where the new residual is
between this ratio of the expected one and its inverse."""
SHORTENINGS = 4
"""Shares of a linear step that a fit may begin with, at most; each is `SHORTENED_STEP` of the one before."""


@dataclass(frozen=True, eq=False)
class Linearisation:
    """What structures are compared on.

    Attributes:
        space: candidates and their matrix there.
        near: the equations, with slopes along the motion that is expected there.
    """

    space: Space
    near: Unweighted

    @classmethod
    def of(cls, bare: Unweighted, here: Hypothesis, own: list[Proposal], first: Library | None) -> Linearisation:
        """The equations near a hypothesis.

        Args:
            bare: the equations of the model as given, with the noise that the records show.
            here: the hypothesis.
            own: proposals of effects, without the harmonics of this residual.
            first: the library at the model as given; None: this is it.

        Raises:
            SimulationError: the equations are not finite.
        """
        at = bare.equations.of(here.model())
        bare = dataclasses.replace(bare, noise=quieter(bare.noise, at, bare.mask)).with_offsets_of(at)
        seen = rows_of(bare)
        work = weighed(bare, at, filter_error(bare.equations, here))
        work, in_slopes = along_expected(work, here, at)
        along = work.bare.sloping(at)
        left, slopes = work.whiten(at.residual), slopes_of_numbers(here, along, work)
        require_finite(left, slopes)
        listed = with_harmonics(at, work.calm(at.residual), own, runs_of(bare.mask, list(seen.lengths), len(at.kinds)))
        if first is None:
            check_memory(listed, bare.mask.size, sum(float(each.t[-1] - each.t[0]) for each in at.motions))
        library = Library(along, work, here, slopes, tuple(listed), first)
        return cls(Space(library, left, seen, in_slopes), work.bare)

    def best_fitted(self, structure: Structure, steps: int, *, whole: bool = False) -> Fit:
        """The fit of a structure, from its coefficients in the linear equations.

        The first weights are those that the linear equations promise. If the fit does not keep the promise, weights by
        what its first values leave are tried as well. Where the equations are far from linear, both may end less likely
        than the linearisation's own point, or have no finite equations to begin with. The fit is then begun anew from a
        share of the step. The most likely fit counts; if there is none, that of the linearisation's own point.

        Args:
            structure: of the space.
            steps: largest number of steps of each fit.
            whole: see `hypothesis_of`.
        """
        space, here = self.space, self.space.library.start
        own, start = space.estimate(structure), self._begun(structure, whole=whole)
        promised, before = self._promised(structure), self._log_density(here)
        best, most = self._if_finite(start, steps, promised), space.log_density(own) - OCCAM_WINDOW
        if promised and (best is None or self._log_density(best.hypothesis) <= most):
            best = self._likelier(best, self._if_finite(start, steps, None))
        if best is None or self._log_density(best.hypothesis) <= before - OCCAM_WINDOW:
            best = self._likelier(best, self._if_finite(self._shortened(structure, whole=whole), steps, promised))
        return self.fitted(dataclasses.replace(here, fits_cycles=whole), steps) if best is None else best

    def _begun(self, structure: Structure, *, whole: bool, share: float = 1.0) -> Hypothesis:
        """First values of a structure; its fit moves cycles only if it is whole."""
        there = hypothesis_of(self.space, structure, whole=whole, share=share)
        return dataclasses.replace(there, fits_cycles=whole)

    def _likelier(self, one: Fit | None, other: Fit | None) -> Fit | None:
        """The more likely one of two fits."""
        if one is None or other is None:
            return one or other
        return max(one, other, key=lambda each: self._log_density(each.hypothesis))

    def _if_finite(self, there: Hypothesis, steps: int, error: ModelError | None) -> Fit | None:
        """The fit of a hypothesis; None where its equations are not finite."""
        try:
            return self.fitted(there, steps, error)
        except SimulationError:
            return None

    def _promised(self, structure: Structure) -> ModelError | None:
        """The model error that the linear equations leave of a structure; None where that is not finite.

        Nor is there a promise for links that are simulated behind prescribed motors: there they are far from linear.
        """
        if self.near.equations.replayed.any():
            return None
        left = self.space.left(structure)
        return ModelError.of(left, self.space.seen, about_mean=True) if np.isfinite(left @ left) else None

    def _shortened(self, structure: Structure, *, whole: bool) -> Hypothesis:
        """First values of a structure: shares of its step are tried as long as each is more likely than the last."""

        def begun(share: float) -> tuple[float, Hypothesis]:
            """Log density of the first values after a share of the step, and these values."""
            there = self._begun(structure, whole=whole, share=share)
            return self._log_density(there), there

        best = begun(SHORTENED_STEP)
        for k in range(2, SHORTENINGS + 1):
            tried = begun(SHORTENED_STEP**k)
            if tried[0] <= best[0]:
                break
            best = tried
        return best[1]

    def _log_density(self, there: Hypothesis) -> float:
        """Of a hypothesis as it is, under weights that all share; -inf where its equations are not finite."""
        work = dataclasses.replace(self.plain, beliefs=beliefs(self.space.library, there.effects))
        return log_density_at(self.space, there, work)

    @lazy
    def plain(self) -> Workspace:
        """Weights by the sensors' noise alone; where rows are full of it, they follow the numbers that it is times."""
        near, made = self.near, weighed(self.near)
        return dataclasses.replace(made, anew=lambda at: weighed(near, at)) if near.equations.noisy else made

    def fitted(self, there: Hypothesis, steps: int, error: ModelError | None = None) -> Fit:
        """The fit of a hypothesis, with weights by what the last fit left until they suit it.

        Args:
            there: first values.
            steps: largest number of steps of each fit.
            error: model error that the first fit is expected to leave; None: that of the first values. Where these are
                far off at one joint, they leave so much there that the fit would not mend it.
        """
        priors, most = beliefs(self.space.library, there.effects), -math.inf
        for k in range(WEIGHTINGS):
            work = dataclasses.replace(for_fit(self.near, there, error), beliefs=priors)
            made = _natural(fit(there, work, steps=steps), self.space, work)
            there, likely = made.hypothesis, self._log_density(made.hypothesis)
            if k == 0 or likely > most:
                best, most = made, likely
            if _is_well_weighted(made):
                break
            left = error_of(self.plain.at(made.equations), made.equations.residual)
            error = left if error is None else dataclasses.replace(error, scale=left.scale)
        if _is_well_weighted(best):
            return best
        work = for_fit(self.near, best.hypothesis)
        return fit(best.hypothesis, dataclasses.replace(work, beliefs=priors), steps=1)  # weights for its intervals


def _is_well_weighted(made: Fit) -> bool:
    """Whether a fit leaves about what its weights expect."""
    return WELL_WEIGHTED < made.reduced / expected(made.space) < 1.0 / WELL_WEIGHTED


def _natural(fitted: Fit, space: Space, work: Workspace) -> Fit:
    """The fit with harmonics at whole numbers, of cycles or of motor turns, that it does not rule out."""
    std, changes = fitted.std(), {}
    for effect in fitted.hypothesis.effects:
        spread = std.get((effect, effect.cycles))
        if spread is None:
            continue
        owner = next(each for each in space.candidates if each.proposal is not None and each.proposal.is_of(effect))
        now = float(getattr(effect, effect.cycles))
        for value in owner.natural(now):
            if value != now and (value - now) ** 2 < 2.0 * WHOLE_NUMBER_LOG_ODDS * spread**2:
                changes[effect] = effect.replace(**{effect.cycles: value})
                break
    if not changes:
        return fitted
    effects = tuple(changes.get(each, each) for each in fitted.hypothesis.effects)
    return fit(dataclasses.replace(fitted.hypothesis, effects=effects), work, steps=2)
