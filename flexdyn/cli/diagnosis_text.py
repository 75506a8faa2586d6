"""What `flexdyn diagnose` prints of its answer: sentences and tables."""

from __future__ import annotations

import math
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from flexdyn.cli.output import table
from flexdyn.diagnose.report.digits import estimate_text, log_text, percent, probability_text, rounded
from flexdyn.diagnose.report.result import Diagnosis
from flexdyn.diagnose.report.sentences import gap_sentence, model_sentence, stopped_sentence
from flexdyn.diagnose.report.verdicts import verdict_sentence
from flexdyn.diagnose.report.words import effect_name, where_phrase


def diagnosis_text(diagnosis: Diagnosis, folder: Path) -> Iterator[Any]:
    """The verdict, a table of findings, the gap, the errors, notes, where the report is.

    Args:
        diagnosis: as it was saved.
        folder: that it was saved in.
    """
    yield verdict_sentence(diagnosis)
    if diagnosis.findings:
        columns = ("finding", "numbers", "probability", "log Bayes\nfactor", "of the\ntest gap")
        yield table("Findings", columns, list(_findings(diagnosis)), right=columns[2:])
    yield gap_sentence(diagnosis)
    if diagnosis.errors:
        heads = ("joint", "torque error", "share of its torque", "position error")
        title = "Errors on the test data, root mean square: model as given, corrected model"
        yield table(title, heads, list(_errors(diagnosis)), right=heads[1:])
    if diagnosis.verdict != "not_converged" and (stopped := stopped_sentence(diagnosis)):
        yield stopped
    yield from diagnosis.notes
    missing = model_sentence(diagnosis)
    page = f"The report is {folder / 'report.html'}"
    yield f"{page}. {missing}" if missing else f"{page}, the corrected model {folder / 'model.yaml'}"


def _findings(diagnosis: Diagnosis) -> Iterator[tuple[str, ...]]:
    """A row for every name that a finding may have."""
    for finding in diagnosis.findings:
        gain = "-" if math.isnan(finding.test_gain) else percent(finding.test_gain)
        factor = "-" if math.isnan(finding.log_bayes_factor) else log_text(finding.log_bayes_factor)
        together = "together\n" if finding.rivals else ""
        evidence = [(together + probability_text(finding.probability), factor, gain)]
        evidence += [("", "", "")] * len(finding.rivals)
        for place, suspect in enumerate(finding.names):
            numbers = "\n".join(f"{key} {estimate_text(entry)}" for key, entry in suspect.parameters.items())
            own = f" ({probability_text(suspect.probability)})" if finding.rivals else ""
            name = f"{'or ' if place else ''}{effect_name(suspect.effect)}{own}"
            yield f"{name}\n{where_phrase(diagnosis.model, suspect)}", numbers, *evidence[place]


def _errors(diagnosis: Diagnosis) -> Iterator[tuple[str, ...]]:
    """A row for every joint."""
    for joint, entry in diagnosis.errors.items():
        torque = f"{rounded(entry.torque_before)}, {rounded(entry.torque_after)} {entry.torque_unit}"
        share = f"{percent(entry.torque_share_before)}, {percent(entry.torque_share_after)}"
        position = f"{rounded(entry.position_before)}, {rounded(entry.position_after)} {entry.position_unit}"
        yield joint, torque, share, position
