"""Why an effect was named or was not: an answer to ``flexdyn diagnose --explain EFFECT@JOINT``."""

from __future__ import annotations

import math
from collections.abc import Iterator

from flexdyn.diagnose.report.digits import evidence_text, likely, log_text, percent, probability_text
from flexdyn.diagnose.report.measures import Calibration
from flexdyn.diagnose.report.result import Diagnosis
from flexdyn.diagnose.report.suspects import ESTABLISHED, Considered, Finding, Suspect, ranks
from flexdyn.diagnose.report.targets import resolved
from flexdyn.diagnose.report.words import is_number, joined, suspect_phrase, title_phrase

RANKS_LISTED = 5
"""Largest number of ranks that are listed."""


def explanation(diagnosis: Diagnosis, target: str) -> str:
    """The text, one paragraph for every candidate that the target means.

    Args:
        diagnosis: to be explained.
        target: see `Diagnosis.explain`.

    Raises:
        InputError: no such effect, or no such place.
    """
    found = resolved(diagnosis, target)
    parts = [_paragraph(diagnosis, each) for each in found] or [_not_compared(diagnosis, target)]
    if diagnosis.verdict == "interrupted":
        parts.append("The diagnosis was interrupted: this is what was known then.")
    return "\n\n".join(parts)


def _paragraph(diagnosis: Diagnosis, suspect: Suspect) -> str:
    entry = next((each for each in diagnosis.considered if each.suspect.key == suspect.key), None)
    finding = next((each for each in diagnosis.findings if suspect.key in {name.key for name in each.names}), None)
    told = [_status(diagnosis, suspect, finding, entry), *_ranks(diagnosis, suspect, entry)]
    told.append(_confused(diagnosis, suspect, finding))
    if entry is not None and entry.note:
        told.append(entry.note)
    return "\n".join([title_phrase(diagnosis.model, suspect), *(f"  {line}" for line in told if line)])


def _status(diagnosis: Diagnosis, suspect: Suspect, finding: Finding | None, entry: Considered | None) -> str:
    """Whether it was named, its probability, and the reasons for it."""
    probability = _marginal(diagnosis, suspect, entry)
    said = f"{probability_text(probability)} ({likely(probability)})"
    moved = _calibrated(diagnosis, suspect)
    if finding is not None and not finding.rivals:
        held = "Named" if finding.established else f"Listed among the findings, below {ESTABLISHED}"
        return f"{held}: its probability is {probability_text(finding.probability)} ({likely(finding.probability)})."
    if finding is not None:
        together = probability_text(finding.probability)
        return f"Named as one of {len(finding.names)}: together they have probability {together}; alone it has {said}."
    if moved is not None:
        return (
            f"Calibrated, and no finding: factor {moved.factor:.4g} with standard deviation {moved.std:.2g}, at a"
            f" tolerance of {percent(moved.tolerance)}; a number is called wrong only beyond 3 tolerances."
        )
    below = f", and {ESTABLISHED} is required" if probability < ESTABLISHED else ""
    return f"Not named: its probability is {said}{below}."


def _marginal(diagnosis: Diagnosis, suspect: Suspect, entry: Considered | None) -> float:
    """Its marginal probability: as computed, else as its structures have it."""
    for known in (entry.probability if entry else math.nan, suspect.probability):
        if math.isfinite(known):
            return known
    return ranks(diagnosis.structures, [suspect]).probability if diagnosis.structures else math.nan


def _ranks(diagnosis: Diagnosis, suspect: Suspect, entry: Considered | None) -> Iterator[str]:
    """Which of the ranked structures hold it, and its Bayes factor."""
    found = ranks(diagnosis.structures, [suspect])
    if found.among and not found.holding:
        yield f"It stands in none of the {found.among} ranked structures."
    elif found.among:
        few = [str(place) for place in found.holding[:RANKS_LISTED]]
        more = ", ..." if found.holding[RANKS_LISTED:] else ""
        word = "rank" if len(found.holding) == 1 else "ranks"
        yield (
            f"It stands in {len(found.holding)} of {found.among} ranked structures ({word} {', '.join(few)}{more}),"
            f" which together have probability {probability_text(found.probability)}."
        )
    factor = entry.log_bayes_factor if entry is not None else math.nan
    if not math.isnan(factor):
        yield f"Log Bayes factor of the best structure with it against the best without it: {evidence_text(factor)}."
    elif found.log_bayes_factor is not None:
        yield (
            "Of the ranked structures, the best with it and the best without it differ by a log evidence of"
            f" {log_text(found.log_bayes_factor)}."
        )


def _confused(diagnosis: Diagnosis, suspect: Suspect, finding: Finding | None) -> str:
    """The effects from which the data cannot separate it."""
    others = [] if finding is None else [each for each in finding.names if each.key != suspect.key]
    if not others:
        return "No other effect is listed that explains the data equally well."
    names = [f"{suspect_phrase(diagnosis.model, each)}{_own(each)}" for each in others]
    apart = f" What would tell them apart: {finding.experiment}" if finding and finding.experiment else ""
    return f"These data do not tell it from {joined(names)}.{apart}"


def _own(suspect: Suspect) -> str:
    known = math.isfinite(suspect.probability)
    return f" (probability {probability_text(suspect.probability)})" if known else ""


def _calibrated(diagnosis: Diagnosis, suspect: Suspect) -> Calibration | None:
    """The number of a parameter error, if it was calibrated within its tolerance."""
    if not is_number(suspect):
        return None
    whose = (suspect.place.get("of"), suspect.place.get("parameter"))
    return next((each for each in diagnosis.calibration if (each.of, each.parameter) == whose), None)


def _not_compared(diagnosis: Diagnosis, target: str) -> str:
    """The text for an effect and a joint that exist but were not a candidate."""
    stop = " before it was interrupted" if diagnosis.verdict == "interrupted" else ""
    return f"{target}\n  Not named: the search compared no such candidate{stop}."
