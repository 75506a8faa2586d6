"""Fits with another candidate in the place of one that the linear equations can hardly tell from it."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterator

from flexdyn.arrays import Flags
from flexdyn.diagnose.constants import EVEN_ODDS_WINDOW, OCCAM_WINDOW, RIVAL_LOSS
from flexdyn.diagnose.decision.fitted_structure import FittedStructure
from flexdyn.diagnose.decision.model_effects import without_effect
from flexdyn.diagnose.equations.mask import passage_mask
from flexdyn.diagnose.hypothesis.fitted import Fit
from flexdyn.diagnose.hypothesis.hypothesis import Hypothesis
from flexdyn.diagnose.inference.candidate import Candidate
from flexdyn.diagnose.inference.passes import Posterior
from flexdyn.diagnose.inference.posterior_of_fit import fit_if_likely, log_density_at, log_posterior
from flexdyn.diagnose.inference.scan import Scan
from flexdyn.diagnose.inference.space import Space, Structure
from flexdyn.diagnose.inference.structure_model import effect_of, hypothesis_of, waits
from flexdyn.effects import effect_from_dict


def rivals_in_fits(found: Posterior) -> Posterior:
    """The posterior whose best structure has a rival in it where a fit makes that more likely by more than a mention.

    The linear equations are wrong by the squares of the changes. So they may prefer a candidate to another one that
    moves the rows almost as it does, though a fit with the other one is as good. Each candidate of the best structure
    is replaced by each of these. The odds by fits are kept for the probabilities of names.

    Args:
        found: the posterior, whose best structure is fitted to the equations.
    """
    space, hidden = found.space, passage_mask(found.fitted.equations, found.noise)
    value = log_posterior(space, found.best, found.fitted)
    first = FittedStructure.of(space, found.best, value, found.fitted, hidden)
    here, made = _plainest(space, first, found.fitted, hidden)
    plainer = [here.odds_to(first)] if here is not first else []
    tried, likely, fitted = [], here, made  # one fit at a time is kept: they are large
    for structure, start in (*_swapped(space, here.structure), *_one_sided(space, here.structure, made)):
        value, other = fit_if_likely(space, structure, start, made, here.promised - OCCAM_WINDOW)
        if other is None:
            continue
        tried.append(FittedStructure.of(space, structure, value, other, hidden).beside(here, space))
        if tried[-1].value > max(likely.value, here.value + EVEN_ODDS_WINDOW):
            likely, fitted = tried[-1], other
    odds = [(each if each is likely else each.beside(likely, space)).odds_to(here) for each in tried]
    by_fits = (*found.by_fits, *plainer, *odds)
    return dataclasses.replace(found, best=likely.structure, fitted=fitted, by_fits=by_fits)


def _plainest(space: Space, here: FittedStructure, made: Fit, hidden: Flags) -> tuple[FittedStructure, Fit]:
    """A fit, or one with a plainer law in the place of one where that is more likely; it begins at the same numbers."""
    for each in sorted(here.structure):
        me, before, whole = space.candidates[each[0]], here, made
        for c, plainer in enumerate(space.candidates):
            if plainer.kind not in me.law.plainer or plainer.spot != me.spot or c in dict(before.structure):
                continue
            structure = before.structure - {each} | {(c, 0)}
            start = _with_plainer(whole.hypothesis, me, plainer) or hypothesis_of(space, structure, whole=True)
            value, other = fit_if_likely(space, structure, start, whole, -math.inf)
            if other is None:
                continue
            tried = FittedStructure.of(space, structure, value, other, hidden)
            if tried.value > here.value:
                here, made = tried, other
    return here, made


def _with_plainer(here: Hypothesis, candidate: Candidate, plainer: Candidate) -> Hypothesis | None:
    """A hypothesis with a plainer law in the place of one, at the same numbers; None where they are other numbers."""
    effect = effect_of(candidate, here)
    names = [entry.name for entry in plainer.law.parameters()]
    if effect is None or not all(hasattr(effect, name) for name in names):
        return None
    numbers = {name: getattr(effect, name) for name in names}
    return here.with_instead(effect, effect_from_dict({"effect": plainer.kind, **plainer.place, **numbers}))


def _swapped(space: Space, best: Structure) -> list[tuple[Structure, Hypothesis]]:
    """The best structure with another candidate in the place of one, which keeps nearly all that that one gains."""
    scan, found = Scan(space), []
    for each in sorted(best):
        rest, related = best - {each}, _related(space, each[0])
        lost = RIVAL_LOSS * (space.value(best) - space.value(rest))
        others = [other for gain, other in scan.additions(rest) if gain > 0.0 and not waits(space, other[0])]
        there = [rest | {other} for other in others if other[0] not in related]
        near = [structure for structure in there if space.value(structure) > space.value(best) - lost]
        found += [(structure, hypothesis_of(space, structure, whole=True)) for structure in near]
    return found


def _one_sided(space: Space, best: Structure, made: Fit) -> Iterator[tuple[Structure, Hypothesis]]:
    """The best structure with a law of the deflection, such as a backlash, in the place of an encoder's offset.

    A backlash that touches one side only is such an offset. The linear equations compare it where the offset still
    acts, and it has no linear number that makes up for that. So its grid is tried with the other numbers of the fit.
    """
    for each in sorted(best):
        offset = space.candidates[each[0]]
        if offset.proposal is None or not (offset.law.position_error and offset.law.is_constant):
            continue
        rest = without_effect(made.hypothesis, effect_of(offset, made.hypothesis))
        for c, rival in enumerate(space.candidates):
            there = rival.proposal
            if there is None or rival.law.stage != "deflection" or not there.fixed or rival.stands is not None:
                continue
            effects = [there.make(point, ()) for point in rival.points]
            tried = {
                p: dataclasses.replace(rest, effects=(*rest.effects, effect))
                for p, effect in enumerate(effects)
                if effect is not None and there.joint == offset.proposal.joint
            }
            if tried:
                p = max(tried, key=lambda p: log_density_at(space, tried[p], made.space))
                yield best - {each} | {(c, p)}, tried[p]


def _related(space: Space, c: int) -> set[int]:
    """A candidate, and laws at its place that contain it or that it contains: the plainer one of these is told."""
    me = space.candidates[c]
    inside = {*me.law.contains, *me.law.plainer}
    there = [(k, other) for k, other in enumerate(space.candidates) if other.spot == me.spot]
    return {c, *(k for k, each in there if each.kind in inside or me.kind in (*each.law.contains, *each.law.plainer))}
