"""Texts of the page about a finding: its title, its numbers, the evidence for its name; and about a structure."""

from __future__ import annotations

from flexdyn.diagnose.report import words
from flexdyn.diagnose.report.digits import estimate_text
from flexdyn.diagnose.report.result import Diagnosis
from flexdyn.diagnose.report.suspects import Finding, Structure, Suspect, beyond
from flexdyn.effects import catalogue
from flexdyn.model.flexible_joint_model import FlexibleJointModel

FINDINGS_OPEN = 4
"""Number of findings that are shown in full at once; the others open on a click."""
STRUCTURES_OPEN = 8
"""Number of structures that are shown at once; the others open on a click."""


def finding_title(model: FlexibleJointModel, finding: Finding) -> str:
    """Names of what it may be in one place."""
    suspect = finding.suspect
    first = (
        f"wrong {words.where_phrase(model, suspect)}" if words.is_number(suspect) else words.effect_name(suspect.effect)
    )
    names = [first, *(words.effect_name(each.effect) for each in words.in_one_place(model, finding))]
    return words.capital(" or ".join(dict.fromkeys(names)))


def finding_places(model: FlexibleJointModel, finding: Finding) -> str:
    """Where it acts, and rivals at other places; empty if the title says that."""
    here = [] if words.is_number(finding.suspect) else [words.where_phrase(model, finding.suspect)]
    alike = words.in_one_place(model, finding)
    return ", ".join(
        [*here, *(f"or {words.suspect_phrase(model, rival)}" for rival in finding.rivals if rival not in alike)]
    )


def law_text(suspect: Suspect) -> str:
    """The law of an effect as the catalogue states it."""
    kind = catalogue().get(suspect.effect)
    return kind.law if kind is not None else ""


def estimates(suspect: Suspect) -> str:
    """All its numbers in a line."""
    return ", ".join(f"{name} {estimate_text(number)}" for name, number in suspect.parameters.items())


def structure_lines(diagnosis: Diagnosis, rank: int, entry: Structure) -> list[str]:
    """Its effects; of the second and those after it, what they have more and less than the first."""
    first = diagnosis.structures[0]
    if not entry.effects:
        return ["No effect: the calibrated model alone"]
    own = [words.plain_phrase(phrase) for phrase in words.grouped_phrases(diagnosis.model, entry.effects)]
    more, less = (beyond(*pair) for pair in ((entry, first), (first, entry)))
    if rank == 1 or len(more) + len(less) >= len(entry.effects):
        return own
    lines = [f"without {phrase}" for phrase in words.grouped_phrases(diagnosis.model, less)]
    lines += [f"with {phrase}" for phrase in words.grouped_phrases(diagnosis.model, more)]
    return ["As rank 1", *lines] if lines else ["The effects of rank 1, with other numbers"]
