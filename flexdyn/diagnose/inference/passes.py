"""The posterior over structures: linearise, compare, fit, and again from there until nothing changes."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from flexdyn.diagnose.constants import STRONG_GAIN_SHARE
from flexdyn.diagnose.equations.covariance import SampleNoise
from flexdyn.diagnose.hypothesis.fitted import Fit
from flexdyn.diagnose.hypothesis.hypothesis import Hypothesis
from flexdyn.diagnose.hypothesis.unweighted import Unweighted
from flexdyn.diagnose.hypothesis.workspace import beginning_as
from flexdyn.diagnose.inference.catalogue import everything
from flexdyn.diagnose.inference.library import Library
from flexdyn.diagnose.inference.linearisation import Linearisation
from flexdyn.diagnose.inference.model_error import ModelError
from flexdyn.diagnose.inference.odds_by_fits import (
    LAST_STEPS,
    best_by_fits,
    best_where_not_linear,
    most_likely_visited,
    odds_by_fits,
)
from flexdyn.diagnose.inference.posterior_of_fit import leaves_more_than_noise, squares_left
from flexdyn.diagnose.inference.rivals import among_rivals
from flexdyn.diagnose.inference.search import explore
from flexdyn.diagnose.inference.shapes import likeliest_shapes
from flexdyn.diagnose.inference.space import Identities, Space, Structure
from flexdyn.diagnose.inference.structure_model import hypothesis_of, standing, waits
from flexdyn.diagnose.lazy import lazy
from flexdyn.diagnose.progress import know, tell

MOST_PASSES, PASSES_OF_MANY, MANY_CELLS = 10, 7, 2e7
"""Linearisations at most; where rows times columns are more than this number, fewer: each takes half a minute there."""
MODEL_ERROR_ROUNDS = 25
"""Times that model error and structure are estimated in turn, at most."""
STALLED_SHARE = 0.3
"""Share of what a pass on simulated links left from which the next one has come no further [1]: right laws leave noise,
or orders less where several are missing."""
PASS_STEPS = 4
"""Gauss-Newton steps at most between two linearisations."""


@dataclass(frozen=True, eq=False)
class Posterior:
    """What was compared.

    Attributes:
        bare: the equations of the model as given, without weights.
        space: candidates and their matrix, at the best structure and under its model error.
        best: the most likely structure.
        fitted: it, by Gauss-Newton.
        settled: whether the last pass changed nothing.
        known: log posteriors of the structures that were compared, not normalised.
        earlier: kinds and places of the best structures at other linearisations, where these do not agree: of a cycle
            since it began; if the search did not settle, all but that at the file's numbers.
        expected: kinds of effects that the user expects of this drive.
        by_fits: structures, each with a set that has one candidate more or one other, and the odds to that by fits.
        left_out: candidates without which a fit is more likely: log odds by it, and what the equations promised [1].
        rejected: candidates that simulated windows reject: log odds of what they prefer in their place [1].
    """

    bare: Unweighted
    space: Space
    best: Structure
    fitted: Fit
    settled: bool
    known: Mapping[Structure, float]
    expected: tuple[str, ...] = ()
    earlier: tuple[Identities, ...] = ()
    by_fits: tuple[tuple[Structure, frozenset[int], float], ...] = ()
    left_out: Mapping[int, float] = dataclasses.field(default_factory=dict)
    rejected: Mapping[int, float] = dataclasses.field(default_factory=dict)

    @property
    def noise(self) -> SampleNoise:
        """Of the channels."""
        return self.fitted.space.noise

    @lazy
    def other_linearisations(self) -> tuple[tuple[frozenset[int], float], ...]:
        """Candidates of this space that each of `earlier` holds, and their odds to the best structure by fits."""
        sets = [self.space.having(identities) for identities in self.earlier]
        return tuple(zip(sets, odds_by_fits(self.space, self.best, self.fitted, sets), strict=True)) if sets else ()


def passes(bare: Unweighted, here: Hypothesis) -> Posterior:
    """Compare structures on one kind of equations.

    Where links are simulated, a pass that leaves more than noise, and not much less than the last one, ends it.

    Args:
        bare: these equations.
        here: where to linearise first.
    """
    own = everything(bare.equations)
    first: Library | None = None
    compared: list[Identities] = []
    passed: set[tuple[Identities, Identities]] = set()
    visited: list[tuple[Identities, Hypothesis]] = []
    least = math.inf
    most = MOST_PASSES
    for k in range(MOST_PASSES):
        tell(f"comparing structures: pass {k + 1} of at most {most}", 0.05 + 0.6 * k / most)
        bare = beginning_as(bare, here)
        near = Linearisation.of(bare, here, own, first)
        space = near.space
        if first is None and space.seen.valid.size * space.matrix.used > MANY_CELLS:
            most = PASSES_OF_MANY
        first = first or space.library
        know(space=space)
        stands = standing(space)
        best = _best_here(space, stands)
        if bare.equations.simulated or best != stands:
            likeliest = best_by_fits if bare.equations.simulated else best_where_not_linear
            best = likeliest(space, best, near.fitted(hypothesis_of(space, stands), PASS_STEPS), stands)
        places, at = space.identities(best), space.identities(stands)
        # Where the file's numbers are far off, nothing may look worth adding: only a fit's linearisation can say that.
        stays = k > 0 and _nonlinear(space, best) == _nonlinear(space, stands)
        # A structure that comes again counts where it comes from the same one: weights and slopes follow what stands.
        # Fits of links that are simulated often stall; there it counts at once.
        settled = stays or (places in compared if bare.equations.replayed.any() else (at, places) in passed)
        passed.add((at, places))
        earlier = () if stays else linearised_elsewhere(compared, places)
        compared.append(places)
        if settled or k == most - 1:
            break
        strong = best if bare.equations.simulated else _strong(space, best, stands, STRONG_GAIN_SHARE ** (k + 1))
        made = likeliest_shapes(space, strong, near.best_fitted(strong, PASS_STEPS))
        if bare.equations.simulated and leaves_more_than_noise(made):
            before = least if k else float(squares_left(bare.equations.of(here.model()), near.plain)[0].sum())
            least = float(squares_left(made.equations, made.space)[0].sum())
            if least > STALLED_SHARE * before:
                return Posterior(bare, space, strong, made, False, space.known)
        here = dataclasses.replace(made.hypothesis, fits_cycles=True)
        visited.append((space.identities(strong), here))
        space.forget()
    space.known = {}
    best = among_rivals(space, explore(space, [best]))
    fitted = near.best_fitted(best, LAST_STEPS, whole=True)
    if not settled:
        best, fitted = most_likely_visited(space, best, fitted, visited)
    fitted = likeliest_shapes(space, best, fitted)
    return Posterior(bare, space, best, fitted, settled, space.known, earlier=earlier)


def linearised_elsewhere(compared: list[Identities], places: Identities) -> tuple[Identities, ...]:
    """Structures at other linearisations.

    Those since the same one was compared before; if it never was, all but that at the file's numbers.
    """
    since = len(compared) - 1 - compared[::-1].index(places) if places in compared else 0
    return tuple(compared[since + 1 :])


def _best_here(space: Space, stands: Structure) -> Structure:
    """The best structure at a linearisation, under the model error that it leaves."""
    space.under(ModelError.of(np.zeros(space.seen.valid.size), space.seen))  # the noise of the sensors alone
    space.under(ModelError.of(space.left(stands), space.seen))
    best, seen = stands, set[Structure]()
    for _ in range(MODEL_ERROR_ROUNDS):
        best = explore(space, [best], 0)
        if best in seen:
            break
        seen.add(best)
        space.under(ModelError.of(space.left(best), space.seen))
    return best


def _strong(space: Space, best: Structure, stands: Structure, least: float) -> Structure:
    """The structure without new effects that are weak compared with the strongest new one.

    If a strong effect is nonlinear, weak effects explain the error of its linearisation, which disappears in the fit.
    """
    value = space.value(best)
    lost = {each: value - space.value(best - {each}) for each in sorted(best - stands)}
    most = max(lost.values(), default=0.0)
    return best - {each for each, loss in lost.items() if loss < least * most}


def _nonlinear(space: Space, structure: Structure) -> set[int]:
    """Candidates of a structure but those that stay linear until the end."""
    return {c for c, _ in structure if not waits(space, c)}
