"""The experiment for every "A or B": each rival is fitted instead of the named effect."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence

from flexdyn.diagnose.decision.corrected import Corrected, effect_of, needed
from flexdyn.diagnose.decision.naming import Name
from flexdyn.diagnose.decision.suspects import suspect_of
from flexdyn.diagnose.equations.covariance import SampleNoise
from flexdyn.diagnose.experiment.design import with_experiment
from flexdyn.diagnose.hypothesis.estimate import fit
from flexdyn.diagnose.hypothesis.fitted import Fit
from flexdyn.diagnose.hypothesis.hypothesis import Hypothesis
from flexdyn.diagnose.report.suspects import Finding

RIVAL_STEPS = 4
"""Gauss-Newton steps of a rival's fit, with a warm start at the linear estimate; the motion is tried with it anyway."""


def with_experiments(
    findings: Sequence[Finding], found: Corrected, named: Sequence[Name], noise: SampleNoise
) -> tuple[Finding, ...]:
    """Findings with rivals, each with the motion that separates them in simulation.

    Args:
        findings: those that are reported.
        found: the corrected model.
        named: what the findings are of, in any order.
        noise: of the channels.
    """
    if found.space.library.equations.data[0].forced.any():  # motions of an arm by its own motors are no test of a rig
        return tuple(findings)
    model = found.hypothesis.given
    names = {suspect_of(model, found.candidates[each.candidate]).key: each for each in named}
    made = []
    for finding in findings:
        fits = _rivals(found, names[finding.suspect.key]) if finding.rivals else []
        whole = len(fits) == len(finding.rivals)
        made.append(with_experiment(finding, found.fitted, fits, found.fitted.space, noise) if whole else finding)
    return tuple(made)


def _rivals(found: Corrected, name: Name) -> list[Fit]:
    """Fits with each rival in the place of the named candidate; those that make no sense are left out."""
    starts = (_in_place(found, rival, name.candidate) for rival in name.rivals)
    return [fit(each, found.fitted.space, steps=RIVAL_STEPS) for each in starts if each is not None]


def _in_place(found: Corrected, rival: int, of: int) -> Hypothesis | None:
    """The corrected model with a rival in the place of a candidate, from the best structure that has it so."""
    structure = found.instead(rival, of)
    if structure is None:
        return None
    rest, number = found.without(of), found.candidates[rival].number
    if number is not None:
        factors = {**rest.factors, number: structure.factors[number]}
        return dataclasses.replace(rest, factors=factors, freed=rest.freed | {number})
    effect = effect_of(found.candidates[rival], structure)
    if effect is None:
        return None
    soft = {getattr(each, "joint", "") for each in rest.effects if each.makes_elastic}
    more = [e for e in needed(structure, [effect]) if not e.makes_elastic or getattr(e, "joint", "") not in soft]
    return dataclasses.replace(rest, effects=(*rest.effects, *more))
