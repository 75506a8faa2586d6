"""From the last stage of the search to the answer: final numbers, which names stand, the gap, the verdict."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from flexdyn.diagnose import faint
from flexdyn.diagnose.abreast import abreast
from flexdyn.diagnose.candidates import FAR_ABOVE, Candidate, candidates
from flexdyn.diagnose.contest import contested
from flexdyn.diagnose.estimate import fit
from flexdyn.diagnose.experiment import with_experiment
from flexdyn.diagnose.filter_bias import with_filter_bias
from flexdyn.diagnose.findings import calibrations, finding, out_of_tolerance, suspected, tried
from flexdyn.diagnose.fitted import ROUGH
from flexdyn.diagnose.gap import shoot
from flexdyn.diagnose.hypothesis import Hypothesis
from flexdyn.diagnose.localise import localise, traces
from flexdyn.diagnose.measured import Measured
from flexdyn.diagnose.nesting import simplified
from flexdyn.diagnose.numbers import FileNumber
from flexdyn.diagnose.refine import Refined, of_fit, refine
from flexdyn.diagnose.result import Diagnosis, Finding, Gap
from flexdyn.diagnose.rivals import is_rival, slack
from flexdyn.diagnose.search import Search
from flexdyn.diagnose.settling import again
from flexdyn.diagnose.stage import Named, Stage
from flexdyn.diagnose.standing import explained, idle, standing, surely, unbent, verdict
from flexdyn.diagnose.verify import SURE, better
from flexdyn.diagnose.windows import Windows
from flexdyn.model import FlexibleJointModel

Array = NDArray[np.float64]
ROUNDS, FEWER = 3, 2
"""Gauss-Newton steps on simulated windows: with time, and without."""
BENT = 0.1
"""Share of its size by which a number has to move for its slopes to be taken anew, without time."""


def concluded(
    model: FlexibleJointModel,
    search: Search,
    stages: Sequence[Stage],
    windows: Windows,
    *,
    hurry: bool = False,
    thorough: bool = False,
) -> Diagnosis:
    """What the stages say, with the gap of the model as given, calibrated and corrected.

    Args:
        model: as given.
        search: that made the stages.
        stages: the first one without any effect, the last one with all.
        windows: of the data of the fit.
        hurry: leave out what only makes the numbers better.
        thorough: look again where more than noise is left.
    """
    first, last = stages[0], stages[-1]
    refined: Refined | None = None
    if last.named and not hurry and (last.fitted.reduced > ROUGH or not explained(last, first)):
        last, refined = _simulated(search, last, windows, thorough=thorough)
    if thorough and last.fitted.reduced > ROUGH and not explained(last, first):
        search, once_more = again(search, stages[-1], windows)
        first, last = once_more[0], once_more[-1]
        last, refined = _simulated(search, last, windows, thorough=True) if last.named else (last, None)
    sure = surely(model, search, last, refined or of_fit(last.fitted))
    refined = refined if sure is last else None
    known = refined or of_fit(sure.fitted)
    last = _freed(search, sure) if explained(sure, first) else standing(search, first, sure, known)
    refined = refined if last is sure else None
    if not last.named and not hurry and not last.trial.exact and explained(last, first):
        last, refined = faint.asked(search, last, windows)
    if refined is None and not hurry:
        last = contested(search, last, windows)
    last, numbers = _final(model, search, last, windows, refined, hurry=hurry)
    corrected, calibrated = numbers.hypothesis.seen(), first.fitted
    within = unbent(search, first).fitted.hypothesis
    gaps = _gaps(model, (within, numbers.hypothesis), windows, search)
    findings = _findings(model, search, first, last, numbers, hurry=hurry)
    space = calibrated.space
    mask = space.whiten.mask
    left = calibrated.regression.left[: len(mask)]  # white rows, a count more or less of the encoders allowed for
    answer = verdict(bool(findings), gaps, near=explained(last, first))
    return Diagnosis(
        verdict=answer,
        findings=findings,
        calibration=calibrations(model, numbers),
        fit=gaps[0],
        check=gaps[1],
        where=() if answer == "no_discrepancy" else localise(calibrated.equations, left, mask),
        model=numbers.hypothesis.model(),
        notes=_notes(model, search.space.equations.data),
        residuals=traces(space.equations, space.equations.of(corrected), mask),
    )


def _gaps(
    model: FlexibleJointModel, hypotheses: tuple[Hypothesis, Hypothesis], windows: Windows, search: Search
) -> list[Gap]:
    """The gap of the fit and of the check under the model as given, calibrated and corrected."""
    models = (model, *(each.seen() for each in hypotheses))
    tried = [trial.shot for trial in search.trials(hypotheses)]  # of the check: mostly known by now
    shots = abreast(lambda pair: shoot(*pair), [*((each, windows) for each in models), (model, search.check.windows)])
    found = []
    for given, calibrated, after in (shots[:3], (shots[3], *tried)):
        found.append(Gap(given.gap, calibrated.gap, after.gap, after.floor()))
    return found


def _freed(search: Search, stage: Stage) -> Stage:
    """Numbers that are surely out of tolerance named for it, beside what would put them back as well."""
    wrong = [each for each in out_of_tolerance(of_fit(stage.fitted)) if not _unseen(each, stage)]
    if not wrong:
        return stage
    hypothesis = stage.fitted.hypothesis
    made = fit(dataclasses.replace(hypothesis, freed=hypothesis.freed | set(wrong)), search.space)
    drop = stage.fitted.chi2 - made.chi2
    named = [Named(Candidate(made, drop, 0.0, None, number, made.chi2)) for number in wrong]
    if len(wrong) == 1:
        rivals = tuple(c for c in candidates(search.space, search.screen, stage.fitted) if c.number != wrong[0])
        one = named[0].candidate
        near = tuple(each for each in rivals if each.behind(one) <= slack(made) and is_rival(each, one))
        named = [dataclasses.replace(named[0], rivals=near)]
    return Stage(made, search.trial(made.hypothesis), (*stage.named, *named))


def _unseen(number: FileNumber, stage: Stage) -> bool:
    """Whether it is a damper's whose deflection nobody measured: positions that are made up take no notice of it."""
    at = stage.fitted.equations
    return number.parameter == "damping" and number.joint is not None and bool(at.made_up[at.true.index(number.joint)])


def _simulated(search: Search, stage: Stage, windows: Windows, *, thorough: bool) -> tuple[Stage, Refined | None]:
    """The stage with its numbers fitted to simulated windows, where the check is surely less off with them."""
    what = "fitting simulated windows"
    refined = refine(
        stage.fitted.hypothesis, windows, ROUNDS if thorough else FEWER, lambda share: search.say(what, share),
        search.space.temper, anew=0.0 if thorough else BENT,
    )  # fmt: skip
    trial = search.trial(refined.hypothesis)
    if better(stage.trial, trial) < SURE:
        return stage, None
    std = np.maximum(refined.std, of_fit(stage.fitted).std)
    return dataclasses.replace(stage, trial=trial), dataclasses.replace(refined, std=std)


def _final(
    model: FlexibleJointModel, search: Search, last: Stage, windows: Windows, refined: Refined | None, *, hurry: bool
) -> tuple[Stage, Refined]:
    """The last stage and its final numbers.

    Where positions are made up, equations know some numbers too poorly to name what windows show well.
    """
    plain = with_filter_bias if last.named and not hurry else of_fit
    numbers = simplified(refined or plain(last.fitted))
    poor = refined is None and not last.trial.exact and not hurry
    if poor and idle(model, last, numbers):
        last, refined = _simulated(search, last, windows, thorough=False)
        numbers = simplified(refined) if refined is not None else numbers
    return last, numbers


def _findings(
    model: FlexibleJointModel, search: Search, first: Stage, last: Stage, numbers: Refined, *, hurry: bool
) -> tuple[Finding, ...]:
    """Named effects with their final numbers, the one that explains most first."""
    found, hopeless = [], FAR_ABOVE * last.fitted.chi2  # as when it was asked what can be left out
    for k, each in enumerate(last.named):
        less = first if each.stays else search.stage(*last.without({k}), hopeless)
        gain = (less.trial.gap - last.trial.gap) / max(first.trial.gap - min(last.trial.gap, 1.0), 1e-9)
        made = finding(model, each.candidate, each.rivals, numbers, float(np.clip(gain, 0.0, 1.0)))
        if made is not None and not hurry:
            others = [other.fitted for other in each.rivals if suspected(model, other) in made.rivals]
            made = with_experiment(made, each.candidate.fitted, others, search.space, search.check.windows.noise)
        if made is not None:
            found.append((gain, dataclasses.replace(made, tried=tried(model, each.among, made.suspect))))
    return tuple(entry for _, entry in sorted(found, key=lambda pair: -pair[0]))


def _notes(model: FlexibleJointModel, data: tuple[Measured, ...]) -> tuple[str, ...]:
    """What the channels that were measured cannot tell."""
    notes = []
    for j, joint in enumerate(model.joint_names):
        elastic, one = bool(model.elastic[j]), data[0]
        if elastic and not one.has_q[j]:
            notes.append(f"{joint}: no link encoder, so friction on link and motor are told apart by the spring alone")
        if elastic and not one.has_theta[j]:
            notes.append(f"{joint}: no motor encoder, so what happens at the rotor is seen through the spring alone")
    return tuple(notes)
