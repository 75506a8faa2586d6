"""What the page says of a structure that was compared."""

from __future__ import annotations

from flexdyn.diagnose.report.result import Diagnosis
from flexdyn.diagnose.report.suspects import Structure, Suspect, beyond
from flexdyn.diagnose.report.words import grouped_phrases, plain_phrase

STRUCTURES_OPEN = 8
"""Structures that stand open; the others are folded away."""


def structure_lines(diagnosis: Diagnosis, rank: int, entry: Structure) -> list[str]:
    """Its effects; of the second and those after it, what they have more and less than the first."""
    first = diagnosis.structures[0]
    if not entry.effects:
        return ["No effect: the calibrated model alone"]
    own = [plain_phrase(phrase) for phrase in grouped_phrases(diagnosis.model, entry.effects)]
    more, less = (beyond(*pair) for pair in ((entry, first), (first, entry)))
    if rank == 1 or len(more) + len(less) >= len(entry.effects):
        return own
    lines = [f"without {phrase}" for phrase in grouped_phrases(diagnosis.model, less)]
    lines += [f"with {phrase}" for phrase in grouped_phrases(diagnosis.model, more)]
    return ["As rank 1", *lines] if lines else ["The effects of rank 1, with other numbers"]


def is_named(diagnosis: Diagnosis, suspect: Suspect) -> bool:
    """Whether a finding names it, alone or as one of several."""
    return any(suspect.key == each.key for finding in diagnosis.findings for each in finding.names)
