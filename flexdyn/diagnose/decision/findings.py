"""Findings, with their numbers, evidence and experiments; numbers of the file that were calibrated."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping, Sequence

from scipy.special import ndtr

from flexdyn.diagnose.constants import ESTABLISHED, IN_TOLERANCE
from flexdyn.diagnose.decision.averaged import FACTOR_NAME, NumberShifts, shifts_of_numbers
from flexdyn.diagnose.decision.corrected import Corrected
from flexdyn.diagnose.decision.gains import in_order
from flexdyn.diagnose.decision.model_effects import with_elasticity
from flexdyn.diagnose.decision.naming import Name
from flexdyn.diagnose.decision.significance import least_deviation
from flexdyn.diagnose.decision.suspects import numbers_of, suspect_of
from flexdyn.diagnose.experiment.design import with_experiment
from flexdyn.diagnose.hypothesis.estimate import fit
from flexdyn.diagnose.hypothesis.fitted import Fit
from flexdyn.diagnose.hypothesis.hypothesis import Hypothesis
from flexdyn.diagnose.inference.candidate import Candidate
from flexdyn.diagnose.inference.structure_model import effect_of, factor_of
from flexdyn.diagnose.report.measures import Calibration
from flexdyn.diagnose.report.suspects import Finding, Number, Suspect
from flexdyn.diagnose.report.words import effect_name, joined
from flexdyn.effects import Effect, SensorEffect
from flexdyn.model.flexible_joint_model import FlexibleJointModel
from flexdyn.model.uncertain_parameters import FileNumber

RIVAL_STEPS = 4
"""Gauss-Newton steps of a rival's fit, with a warm start at the linear estimate; the motion is tried with it anyway."""


def findings(
    model: FlexibleJointModel, found: Corrected, named: Sequence[Name], gains: Mapping[int, float]
) -> tuple[Finding, ...]:
    """Named effects and numbers that are out of their tolerance, the one that explains most first.

    Args:
        model: as given.
        found: the corrected model.
        named: the names that are reported, see `reported_names`.
        gains: by candidate, share of the gap on the test data that it removes.
    """
    shifts = shifts_of_numbers(found)
    made = [_finding_of(model, found, each, gains, shifts) for each in named]
    of = {each.candidate: entry for each, entry in zip(named, made, strict=True)}
    return tuple(of[c] for c in in_order(list(of), gains))


def reported_names(found: Corrected) -> list[Name]:
    """The names that are findings, and numbers without a name that are certainly beyond their tolerance.

    Numbers that came back into their tolerance, and lags of torques within one sample, are no findings. Numbers without
    a name are added only where the equations leave noise alone, and every effect of the best structure has a name:
    otherwise such a number may imitate an effect that has none. They must be beyond it also beside small amounts of
    every law, as structures are compared.
    """
    here, numbers = found.hypothesis, [each.number for each in found.candidates]
    own = [each for each in found.names if (n := numbers[each.candidate]) is None or here.is_beyond(n)]
    own = [each for each in own if not _is_within_a_sample(found, found.effect(each.candidate))]
    unnamed = {c for c in found.genuine if c not in found.named and numbers[c] is None}
    if not found.explained or unnamed or found.fitted.block:  # fits to windows displace numbers
        return own
    std = found.fitted.factor_std()
    for c, number in enumerate(numbers):
        if number is None or c in found.named:
            continue
        least = least_deviation(found.space.places.log_odds(c))
        deviation = _beyond_by(number, here.factors[number], std[number])
        if deviation >= least:
            compared = factor_of(found.space, found.masses.structures[0], number)
            deviation = min(deviation, _beyond_by(number, *compared))
        probability = float(ndtr(deviation)) * found.genuine.get(c, 1.0)
        if probability >= ESTABLISHED and deviation >= least:
            own.append(Name(c, (), probability))
    return own


def lags_within_a_sample(found: Corrected) -> list[SensorEffect]:
    """Lags of torques by at most one sample: the time within the sample at which a torque was read is unknown."""
    effects = found.hypothesis.effects
    return [each for each in effects if isinstance(each, SensorEffect) and _is_within_a_sample(found, each)]


def _is_within_a_sample(found: Corrected, effect: Effect | None) -> bool:
    late_torque = isinstance(effect, SensorEffect) and effect.signal == "tau" and effect.lateness > 0.0
    return effect is not None and late_torque and effect.lateness <= found.fitted.equations.data[0].dt


def _beyond_by(number: FileNumber, factor: float, std: float) -> float:
    """Standard deviations of its factor by which a number is out of its tolerance [1]; negative within it."""
    return (abs(factor - 1.0) - IN_TOLERANCE * number.tolerance) / max(std, 1e-300)


def _finding_of(
    model: FlexibleJointModel, found: Corrected, name: Name, gains: Mapping[int, float], shifts: NumberShifts
) -> Finding:
    masses, candidates, c = found.masses, found.candidates, name.candidate
    compared = c in masses.candidates
    alone = masses.of_any([c]) if name.rivals else name.probability
    numbers = {
        key: dataclasses.replace(one, std=shifts[c, key].widened(one.std)) if (c, key) in shifts else one
        for key, one in _numbers_of_candidate(model, candidates[c], found.hypothesis, found.fitted).items()
    }
    suspect = suspect_of(model, candidates[c], alone, numbers)
    rivals = tuple(
        suspect_of(
            model, candidates[r], masses.of_any([r]), _numbers_of_candidate(model, candidates[r], found.instead(r, c))
        )
        for r in name.rivals
    )
    factor = masses.log_bayes_factor(c) if compared else math.nan
    told = ""
    if rivals:
        told = _experiment(suspect, rivals, on_a_rig=bool(found.space.library.equations.data[0].forced.any()))
    return Finding(suspect, name.probability, factor, gains.get(c, math.nan), rivals, told)


def _numbers_of_candidate(
    model: FlexibleJointModel, candidate: Candidate, here: Hypothesis | None, made: Fit | None = None
) -> dict[str, Number]:
    """Numbers of a candidate in a hypothesis, with the standard deviations of its fit, if there is one."""
    if here is None:
        return {}
    if candidate.number is not None:
        std = math.nan if made is None else made.factor_std()[candidate.number]
        return {FACTOR_NAME: Number(here.factors[candidate.number], std, "1")}
    effect = effect_of(candidate, here)
    return {} if effect is None else numbers_of(model, effect, None if made is None else made.std())


def calibration(found: Corrected, named: Sequence[Name]) -> tuple[Calibration, ...]:
    """Numbers of the file that are no findings.

    Args:
        found: the corrected model.
        named: the names that are reported as findings.
    """
    told = {found.candidates[each.candidate].number for each in named}
    std = found.fitted.factor_std()
    return tuple(
        Calibration(number.of, number.parameter, float(factor), std[number], number.tolerance)
        for number, factor in found.hypothesis.factors.items()
        if number not in told
    )


def _experiment(suspect: Suspect, others: Sequence[Suspect], *, on_a_rig: bool) -> str:
    """General advice: motions in which laws differ; on a rig, those that can be set there."""
    names = joined(list(dict.fromkeys(effect_name(each.effect) for each in (suspect, *others))))
    joint = suspect.joint or "the arm"
    if on_a_rig:
        return (
            f"to tell {names} apart, record {joint} on the rig: with amplitudes from a tenth of today's to the largest "
            "that it allows, because laws that deflect before they slip differ most at small amplitudes; at a tenth "
            "and at twice the speed, because some laws depend on speed; and with another preload, if it can be set"
        )
    return (
        f"to tell {names} apart, move {joint} slowly through its range at several constant speeds in both directions, "
        "stop and reverse often, and repeat it with another load"
    )


def with_experiments(findings: Sequence[Finding], found: Corrected, named: Sequence[Name]) -> tuple[Finding, ...]:
    """Findings with rivals, each with the motion that separates them in simulation.

    Args:
        findings: those that are reported.
        found: the corrected model.
        named: what the findings are of, in any order.
    """
    if found.space.library.equations.data[0].forced.any():  # motions of an arm by its own motors are no test of a rig
        return tuple(findings)
    model = found.hypothesis.given
    names = {suspect_of(model, found.candidates[each.candidate]).key: each for each in named}
    made = []
    for finding in findings:
        fits = _rivals(found, names[finding.suspect.key])
        whole = fits and len(fits) == len(finding.rivals)
        made.append(with_experiment(finding, found.fitted, fits) if whole else finding)
    return tuple(made)


def _rivals(found: Corrected, name: Name) -> list[Fit]:
    """Fits with each rival in the place of the named candidate; without those that are not possible."""
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
    more = [
        e for e in with_elasticity(structure, [effect]) if not e.makes_elastic or getattr(e, "joint", "") not in soft
    ]
    return dataclasses.replace(rest, effects=(*rest.effects, *more))
