"""The verdict in whole sentences, each generated from the numbers of the diagnosis."""

from __future__ import annotations

from flexdyn.diagnose.report.digits import counted, percent, probability_text
from flexdyn.diagnose.report.result import Diagnosis
from flexdyn.diagnose.report.sentences import stopped_sentence
from flexdyn.diagnose.report.suspects import CONFIDENCE, ESTABLISHED, Finding
from flexdyn.diagnose.report.words import finding_phrase, grouped_phrases, joined, place_phrase, suspect_phrase

FINDINGS_IN_ONE_SENTENCE = 2
"""So many findings are all named in one sentence."""


def verdict_sentence(diagnosis: Diagnosis) -> str:
    """The verdict in a sentence or two; of many findings it names the first, of the greatest share."""
    return {
        "no_discrepancy": _no_discrepancy,
        "explained": _explained,
        "partly_explained": _partly_explained,
        "unexplained": _unexplained,
        "not_converged": _not_converged,
        "interrupted": _interrupted,
    }[diagnosis.verdict](diagnosis)


def _no_discrepancy(diagnosis: Diagnosis) -> str:
    moved = sum(abs(entry.factor - 1.0) > CONFIDENCE * entry.std for entry in diagnosis.calibration)
    has = "has" if moved == 1 else "have"
    after = f", after {counted(moved, 'number')} of the model {has} moved within tolerance" if moved else ""
    return f"Model and measurement agree: what is left between them is noise{after}."


def _explained(diagnosis: Diagnosis) -> str:
    return f"The disagreement {_causes(diagnosis)}; what is left is noise."


def _partly_explained(diagnosis: Diagnosis) -> str:
    return f"Part of the disagreement {_causes(diagnosis)}. {_left(diagnosis)}"


def _causes(diagnosis: Diagnosis) -> str:
    phrases = [_with_probability(diagnosis, finding) for finding in diagnosis.findings]
    if len(phrases) > FINDINGS_IN_ONE_SENTENCE:
        return f"has {len(phrases)} causes; the largest is {phrases[0]}"
    return f"is explained by {joined(phrases) if phrases else 'numbers that moved within their tolerance'}"


def _with_probability(diagnosis: Diagnosis, finding: Finding) -> str:
    """A finding with the probability that it, or one of its rivals, is there."""
    together = "together " if finding.rivals else ""
    said = probability_text(finding.probability)
    return f"{finding_phrase(diagnosis.model, finding)} ({together}probability {said})"


def _left(diagnosis: Diagnosis) -> str:
    """What is left, of the joint that has most of it."""
    if not diagnosis.left:
        return "Something is left that no established effect accounts for."
    worst = max(diagnosis.left, key=lambda entry: entry.share_of_torque)
    also = f"; it changes with {joined(worst.depends_on)}" if worst.depends_on else ""
    most = "at most " if len(diagnosis.left) > 1 else ""
    return (
        f"No established effect accounts for what is left: {most}{percent(worst.share_of_torque)} of the torque of"
        f" {worst.joint}{also}."
    )


def _unexplained(diagnosis: Diagnosis) -> str:
    place = diagnosis.where[0] if diagnosis.where else None
    where = f" The residual is largest {place_phrase(place.joint, place.side)}." if place else ""
    return (
        f"Model and measurement disagree, and no effect is established as the cause{_most_probable(diagnosis)}.{where}"
    )


def _most_probable(diagnosis: Diagnosis) -> str:
    """The best name that was not established, with its probability."""
    named = [(each.probability, finding_phrase(diagnosis.model, each)) for each in diagnosis.findings]
    named += [(each.probability, suspect_phrase(diagnosis.model, each.suspect)) for each in diagnosis.considered]
    weak = [(probability, name) for probability, name in named if probability < ESTABLISHED]
    if not weak or len(weak) < len(named):
        return ""
    probability, name = max(weak, key=lambda entry: entry[0])
    return (
        f": the most probable, {name}, has probability {probability_text(probability)}, and {ESTABLISHED} is required"
    )


def _not_converged(diagnosis: Diagnosis) -> str:
    firm = [finding for finding in diagnosis.findings if finding.established]
    stopped = stopped_sentence(diagnosis) or "An estimate stopped before it had converged."
    known = "The report claims only what has converged"
    if not firm:
        return f"{stopped} {known}: no effect is established."
    return f"{stopped} {known}: {_several(diagnosis, firm)}."


def _several(diagnosis: Diagnosis, findings: list[Finding]) -> str:
    """Findings in a row; of many the first and how many more."""
    phrases = [_with_probability(diagnosis, finding) for finding in findings]
    return joined(phrases) if len(phrases) <= FINDINGS_IN_ONE_SENTENCE else f"{phrases[0]} and {len(phrases) - 1} more"


def _interrupted(diagnosis: Diagnosis) -> str:
    firm = [finding for finding in diagnosis.findings if finding.established]
    known = f"Established by then: {_several(diagnosis, firm)}" if firm else "No effect had been established by then"
    at = f" while {stage_phrase(diagnosis.stopped_at)}," if diagnosis.stopped_at else ""
    opened = "" if diagnosis.gap_test else " The test data had not been opened."
    return f"This diagnosis was interrupted{at} before it was finished. {known}{_first_so_far(diagnosis)}.{opened}"


def stage_phrase(stage: str) -> str:
    """``comparing structures, pass 2 of at most 5``: a stage within a sentence."""
    return stage.replace(": ", ", ").replace(" (", ", stage ").removesuffix(")")


def _first_so_far(diagnosis: Diagnosis) -> str:
    """The most probable structure of a comparison that had not ended."""
    if diagnosis.findings or not diagnosis.structures:
        return ""
    first = diagnosis.structures[0].effects
    names = grouped_phrases(diagnosis.model, first)
    what = joined(names) if len(names) <= FINDINGS_IN_ONE_SENTENCE else f"a set of {len(first)} effects, listed below,"
    return f"; the most probable so far was {what if names else 'no effect at all'}"
