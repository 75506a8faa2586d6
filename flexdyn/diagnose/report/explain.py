"""Why an effect was named or was not: an answer to ``flexdyn diagnose --explain EFFECT@JOINT``."""

from __future__ import annotations

import math
from typing import Any

from flexdyn.diagnose.report import digits, words
from flexdyn.diagnose.report.measures import Calibration
from flexdyn.diagnose.report.result import Diagnosis
from flexdyn.diagnose.report.suspects import ESTABLISHED, Suspect, ranks
from flexdyn.diagnose.report.targets import resolved
from flexdyn.io.text import fill

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
    text = fill(
        "diagnose/report/explain.txt",
        **{**vars(digits), **vars(words)},
        diagnosis=diagnosis,
        model=diagnosis.model,
        target=target,
        found=[_facts(diagnosis, each) for each in resolved(diagnosis, target)],
        isnan=math.isnan,
        ESTABLISHED=ESTABLISHED,
        RANKS_LISTED=RANKS_LISTED,
    )
    return text.rstrip("\n")


def _facts(diagnosis: Diagnosis, suspect: Suspect) -> dict[str, Any]:
    """What is told of a candidate: its finding, its entry among those compared, the structures that hold it, rivals."""
    entry = next((each for each in diagnosis.considered if each.suspect.key == suspect.key), None)
    finding = next((each for each in diagnosis.findings if suspect.key in {name.key for name in each.names}), None)
    held = ranks(diagnosis.structures, [suspect])
    # As computed, else as the structures have it.
    known = (entry.probability if entry else math.nan, suspect.probability)
    marginal = held.probability if diagnosis.structures else math.nan
    others = [] if finding is None else [each for each in finding.names if each.key != suspect.key]
    return {
        "suspect": suspect,
        "entry": entry,
        "finding": finding,
        "held": held,
        "probability": next((each for each in known if math.isfinite(each)), marginal),
        "moved": _calibrated(diagnosis, suspect),
        "others": [f"{words.suspect_phrase(diagnosis.model, each)}{_own(each)}" for each in others],
    }


def _own(suspect: Suspect) -> str:
    known = math.isfinite(suspect.probability)
    return f" (probability {digits.probability_text(suspect.probability)})" if known else ""


def _calibrated(diagnosis: Diagnosis, suspect: Suspect) -> Calibration | None:
    """The number of a parameter error, if it was calibrated within its tolerance."""
    if not words.is_number(suspect):
        return None
    whose = (suspect.place.get("of"), suspect.place.get("parameter"))
    return next((each for each in diagnosis.calibration if (each.of, each.parameter) == whose), None)
