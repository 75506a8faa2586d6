"""Parts of report.html: the structures and the candidates that were compared, and why."""

from __future__ import annotations

import math
from html import escape

from flexdyn.diagnose.report.digits import log_text, probability_text
from flexdyn.diagnose.report.document import CONSIDERED
from flexdyn.diagnose.report.html import bar, folded, section, soft, table
from flexdyn.diagnose.report.ranks import beyond
from flexdyn.diagnose.report.result import Diagnosis
from flexdyn.diagnose.report.suspects import Structure
from flexdyn.diagnose.report.words import capital, grouped_phrases, plain_phrase, title_phrase

STRUCTURES_OPEN = 8
"""Structures that stand open; the others are folded away."""


def structures(diagnosis: Diagnosis) -> str:
    """The ranked structures with their probabilities; the candidates; further reasons."""
    parts = [_ranked(diagnosis), _candidates(diagnosis), _decisions(diagnosis)]
    if not any(parts):
        return ""
    title = "Structures compared" if diagnosis.structures else "Candidates compared"
    return section(title, "".join(parts), "structures")


def _ranked(diagnosis: Diagnosis) -> str:
    given = diagnosis.structures
    if not given:
        return ""
    best = max(each.log_evidence for each in given)
    rows = [_row(diagnosis, rank, each, best) for rank, each in enumerate(given, start=1)]
    heads = ("rank", "effects", "probability", "log evidence,<br>to the best")
    shown = table(heads, rows[:STRUCTURES_OPEN], numbers=(3,), name="ranked")
    if rows[STRUCTURES_OPEN:]:
        shown += folded(
            f"{len(rows) - STRUCTURES_OPEN} more", table(heads, rows[STRUCTURES_OPEN:], numbers=(3,), name="ranked")
        )
    said = (
        "A structure is a set of effects that are added to the model. Its probability is posterior, among all"
        " structures that were compared; an effect's probability is the sum over the structures that hold it."
    )
    return soft(said) + shown


def _row(diagnosis: Diagnosis, rank: int, entry: Structure, best: float) -> list[str]:
    share = bar(entry.probability, 1.0, "after", probability_text(entry.probability))
    lines = "<br>".join(escape(line) for line in _effects(diagnosis, rank, entry))
    return [f"{rank}", lines, f'<div class="share">{share}</div>', log_text(entry.log_evidence - best)]


def _effects(diagnosis: Diagnosis, rank: int, entry: Structure) -> list[str]:
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


def _candidates(diagnosis: Diagnosis) -> str:
    """Every candidate that was compared, named or not."""
    given = diagnosis.considered
    if not given:
        return ""
    named = {each.key for finding in diagnosis.findings for each in finding.names}
    rows = [
        [
            f"<b>{name}</b>" if entry.suspect.key in named else name,
            probability_text(entry.probability),
            "" if math.isnan(entry.log_bayes_factor) else log_text(entry.log_bayes_factor),
            escape(entry.note),
        ]
        for entry in given[:CONSIDERED]
        for name in [escape(title_phrase(diagnosis.model, entry.suspect))]
    ]
    heads = ("candidate", "probability", "log Bayes factor", "")
    some = f"the {CONSIDERED} most probable of {len(given)} candidates" if len(given) > CONSIDERED else "all candidates"
    shown = table(heads, rows, numbers=(1, 2), name="candidates")
    return folded(f"{capital(some)}, named or not", shown)


def _decisions(diagnosis: Diagnosis) -> str:
    """Further reasons, by what was decided."""
    if not diagnosis.decisions:
        return ""
    entries = "".join(f"<dt>{escape(what)}</dt><dd>{escape(why)}</dd>" for what, why in diagnosis.decisions.items())
    return folded("Decisions and their reasons", f"<dl>{entries}</dl>")
