"""What a notebook shows of a diagnosis: the verdict, the findings, the gap, the errors."""

from __future__ import annotations

import math
from collections.abc import Iterator

from flexdyn.diagnose.report.digits import errors_text, estimates, percent, probability_text
from flexdyn.diagnose.report.result import Diagnosis
from flexdyn.diagnose.report.sentences import gap_sentence, verdict_sentence
from flexdyn.diagnose.report.words import effect_name, where_phrase
from flexdyn.errors import visible
from flexdyn.io.notebook import card, html_table


def diagnosis_html(diagnosis: Diagnosis) -> str:
    """The HTML."""
    findings = html_table(("finding", "where", "numbers", "probability", "of the test gap"), _findings(diagnosis))
    heads = ("joint", "torque error: given, corrected", "position error: given, corrected")
    off = ((joint, errors_text(each.torque), errors_text(each.position)) for joint, each in diagnosis.errors.items())
    notes = (*diagnosis.notes, "diagnosis.save(folder) writes report.html, report.json and model.yaml")
    facts = {"verdict": diagnosis.verdict, "gap": gap_sentence(diagnosis)}
    return card(verdict_sentence(diagnosis), facts, findings, html_table(heads, off), notes=notes)


def diagnosis_line(diagnosis: Diagnosis) -> str:
    """The verdict and the names found, in a line."""
    found = [f"{each.suspect.effect} at {each.suspect.joint or 'the arm'}" for each in diagnosis.findings]
    more = f", and {len(found) - 3} more" if len(found) > 3 else ""
    names = f": {', '.join(found[:3])}{more}" if found else ""
    return visible(f"<Diagnosis of {diagnosis.model.name}, {diagnosis.verdict}{names}>")


def _findings(diagnosis: Diagnosis) -> Iterator[tuple[str, ...]]:
    for finding in diagnosis.findings:
        gain = "-" if math.isnan(finding.test_gain) else percent(finding.test_gain)
        for place, suspect in enumerate(finding.names):
            name = f"{'or ' if place else ''}{effect_name(suspect.effect)}"
            where = where_phrase(diagnosis.model, suspect)
            evidence = ("", "") if place else (probability_text(finding.probability), gain)
            yield name, where, estimates(suspect.parameters), *evidence
