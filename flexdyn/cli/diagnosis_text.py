"""The output of `flexdyn diagnose`: sentences and tables."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from flexdyn.cli.output import table
from flexdyn.diagnose.report import digits
from flexdyn.diagnose.report.result import Diagnosis
from flexdyn.diagnose.report.sentences import gap_sentence, model_sentence, stopped_sentence, verdict_sentence
from flexdyn.diagnose.report.words import finding_phrase, plain_phrase, suspect_phrase

EVIDENCE = ("no.", "finding", "p", "ln B", "share")
NUMBER_COLUMNS = ("no.", "if it is", "parameter", "estimate", "unit", "95 % interval")
ERRORS = ("joint", "torque error", "of torque", "position error", "in noise")
LEGEND = {
    "p": 'posterior probability; of an "A or B" that of all its names together',
    "ln B": "natural logarithm of the Bayes factor of the best structure with it against the best without it",
    "share": "of the gap on the test data, findings added one after the other",
}
MEANING = {
    "two numbers": "model as given, corrected model",
    "of torque": "torque error over the root mean square of the joint's torque",
    "in noise": "position error in units of what noise alone makes of it",
}


def diagnosis_text(diagnosis: Diagnosis, folder: Path) -> Iterator[Any]:
    """The verdict, tables of findings and their numbers, the gap, the errors, notes, and the path of the report.

    Args:
        diagnosis: that was saved.
        folder: in which it was saved.
    """
    yield verdict_sentence(diagnosis)
    if diagnosis.findings:
        yield table("Findings", EVIDENCE, list(_findings(diagnosis)), right=EVIDENCE[2:], legend=LEGEND)
        numbers = list(_numbers(diagnosis))
        if numbers:
            columns = (
                NUMBER_COLUMNS
                if any(finding.rivals for finding in diagnosis.findings)
                else (NUMBER_COLUMNS[0], *NUMBER_COLUMNS[2:])
            )
            kept = [NUMBER_COLUMNS.index(name) for name in columns]
            yield table("Their numbers", columns, [[row[k] for k in kept] for row in numbers], right=("estimate",))
    yield gap_sentence(diagnosis)
    if diagnosis.errors:
        title = "Errors on the test data, root mean square"
        yield table(title, ERRORS, list(_errors(diagnosis)), right=ERRORS[1:], legend=MEANING)
    if diagnosis.verdict != "not_converged" and (stopped := stopped_sentence(diagnosis)):
        yield stopped
    yield from diagnosis.notes
    missing = model_sentence(diagnosis)
    page = f"The report is {folder / 'report.html'}"
    yield f"{page}. {missing}" if missing else f"{page}, the corrected model {folder / 'model.yaml'}"


def _findings(diagnosis: Diagnosis) -> Iterator[tuple[str, ...]]:
    """A row for every finding, with the probability of each of several names."""
    for k, finding in enumerate(diagnosis.findings):
        factor = "-" if math.isnan(finding.log_bayes_factor) else digits.log_text(finding.log_bayes_factor)
        share = "-" if diagnosis.shares is None else digits.percent(diagnosis.shares.findings[k])
        name = plain_phrase(finding_phrase(diagnosis.model, finding, each=True))
        yield f"{k + 1}", name, digits.probability_text(finding.probability), factor, share


def _numbers(diagnosis: Diagnosis) -> Iterator[tuple[str, ...]]:
    """A row for every number of every name that a finding may have."""
    for k, finding in enumerate(diagnosis.findings, start=1):
        for suspect in finding.names:
            place = plain_phrase(suspect_phrase(diagnosis.model, suspect)) if finding.rivals else ""
            for name, entry in suspect.parameters.items():
                value = digits.value_text(entry.value, entry.std)
                interval = digits.interval_text(dataclasses.replace(entry, unit="1"))
                yield f"{k}", place, name, value, digits.unit_text(entry.unit) or "1", interval
                place = ""


def _errors(diagnosis: Diagnosis) -> Iterator[tuple[str, ...]]:
    """A row for every joint."""
    for joint, entry in diagnosis.errors.items():
        share = f"{digits.percent(entry.torque.share_before)}, {digits.percent(entry.torque.share_after)}"
        position = "prescribed" if entry.force else digits.errors_text(entry.position)
        noise = f"{digits.times(entry.gap[0])}, {digits.times(entry.gap[-1])}" if entry.gap else "-"
        yield joint, digits.errors_text(entry.torque), share, position, noise
