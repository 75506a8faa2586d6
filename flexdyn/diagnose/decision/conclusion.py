"""From what is named to the answer: figures on the data of the fit, then, once, on the test data."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence
from typing import Any

from flexdyn.diagnose.decision.calibrated import calibrated
from flexdyn.diagnose.decision.corrected import Corrected
from flexdyn.diagnose.decision.drawn import compared_motions, ordered_pictures
from flexdyn.diagnose.decision.figures import OnTest, on_test
from flexdyn.diagnose.decision.findings import calibration, findings, reported_names, with_experiments
from flexdyn.diagnose.decision.forces import are_prescribed, loops
from flexdyn.diagnose.decision.judged_by_windows import judged_by_windows
from flexdyn.diagnose.decision.masses import Masses
from flexdyn.diagnose.decision.naming import Name
from flexdyn.diagnose.decision.notes import notes, statistics, unsettled_numbers
from flexdyn.diagnose.decision.split import DataPart, Parts
from flexdyn.diagnose.decision.suspects import considered, structures
from flexdyn.diagnose.decision.verdict import is_noise, verdict
from flexdyn.diagnose.equations.covariance import SampleNoise
from flexdyn.diagnose.hypothesis.hypothesis import Hypothesis
from flexdyn.diagnose.hypothesis.workspace import Workspace
from flexdyn.diagnose.inference.passes import Posterior
from flexdyn.diagnose.inference.space import Space
from flexdyn.diagnose.progress import tell
from flexdyn.diagnose.report.result import Diagnosis
from flexdyn.model.flexible_joint_model import FlexibleJointModel

WORSE = "on the data of the fit the corrected model is worse than the model as it was given"


def concluded(plain: Workspace, start: Hypothesis, compared: Posterior, found: Corrected, parts: Parts) -> Diagnosis:
    """The answer.

    Args:
        plain: equations of the model as given over the data of the fit, with the sensors' weights.
        start: the file's numbers as given.
        compared: the posterior over structures.
        found: the corrected model.
        parts: of the fit, and the test data.
    """
    tell("simulating windows", 0.65)
    made = calibrated(plain, start)
    compared, found, named, first = judged_by_windows(plain, made, compared, found, parts[0])
    tell("opening the test data", 0.85)
    last = on_test(plain, first, found, named, parts[1]) if parts[1] else None
    converged = found.converged and first.stalled is None
    guessed = any(number.is_open for number in found.hypothesis.factors)  # there is no given model to compare with
    only_noise = None if last is None else is_noise(last.shots, last.left)
    said = verdict(named=bool(named), noise=only_noise, converged=converged)
    answer = known(found, named, compared.noise, parts[0], {} if last is None else last.gains)
    if last is not None:
        answer = _tested(answer, last, found.joints)
    tell("designing experiments", 0.9)
    drawn_data = (first,) if last is None else (last, first)
    return dataclasses.replace(
        answer,
        findings=with_experiments(answer.findings, found, named),
        verdict=said,
        gap_fit=first.gap,
        where=() if said == "no_discrepancy" else first.where,
        notes=notes(compared, found, first.gap),
        residuals=ordered_pictures(first.rows, found, named),
        fit=statistics(found.fitted),
        trajectories=tuple(each for on in drawn_data for each in compared_motions(on)),
        loops=tuple(loop for on in drawn_data if are_prescribed(on.parts) for loop in loops(on.rows.models, on.parts)),
        no_model=WORSE if first.worse and not guessed else "",
        stopped=() if converged else unsettled_numbers(first.stalled or found.fitted),
    )


def _tested(answer: Diagnosis, last: OnTest, joints: Sequence[str]) -> Diagnosis:
    """An answer with the figures on its test data."""
    spans = (*answer.data, *(each.source(joints, last.rows.noise) for each in last.parts))
    return dataclasses.replace(
        answer, gap_test=last.gap, errors=last.errors, left=last.left, data=spans, shares=last.shares
    )


def known(
    found: Corrected, named: Sequence[Name], noise: SampleNoise, fitted: Sequence[DataPart], gains: dict[int, float]
) -> Diagnosis:
    """The answer from the fit data alone; the verdict is `interrupted` until the test data have been opened."""
    model = found.hypothesis.given
    return Diagnosis(
        verdict="interrupted",
        findings=findings(model, found, named, gains),
        calibration=calibration(found, named),
        structures=structures(model, found.candidates, found.masses),
        data=tuple(each.source(found.joints, noise) for each in fitted),
        model=found.hypothesis.model(),
        considered=considered(model, found.space, found.masses),
    )


def interrupted(model: FlexibleJointModel, so_far: Mapping[str, Any]) -> Diagnosis:
    """What was known when the user stopped it.

    Args:
        model: as given.
        so_far: what the work had kept: ``fitted`` and ``noise``; ``space`` once structures are compared; ``found`` once
            they have been.
    """
    fitted, noise = so_far["fitted"], so_far["noise"]
    if "found" in so_far:
        return known(so_far["found"], reported_names(so_far["found"]), noise, fitted, {})
    space: Space | None = so_far.get("space")
    masses = Masses.of(dict(space.known)) if space is not None and space.known else None
    return Diagnosis(
        verdict="interrupted",
        findings=(),
        structures=() if space is None or masses is None else structures(model, space.candidates, masses),
        data=tuple(each.source(tuple(model.joint_names), noise) for each in fitted),
        model=model,
        no_model="there was no corrected model yet",
    )
