"""Scales, orders and texts for the page's templates, and how much is shown at once."""

from __future__ import annotations

import math
from collections.abc import Iterable

from flexdyn.diagnose.report import words
from flexdyn.diagnose.report.digits import estimate_text
from flexdyn.diagnose.report.result import Diagnosis
from flexdyn.diagnose.report.suspects import Finding, Suspect
from flexdyn.effects import catalogue
from flexdyn.model.flexible_joint_model import FlexibleJointModel

PICTURES = 6
"""Number of pictures of residuals that are shown at once; the others open on a click."""
OPEN_PICTURE_SHARE = 0.01
"""Smallest share of the squared residuals that a picture explains to be shown at once [1]."""
FINDINGS_OPEN = 4
"""Number of findings that are shown in full at once; the others open on a click."""


def largest(values: Iterable[float]) -> float:
    """The scale of several bars: the largest of the finite values; 1 where that is none or zero."""
    return max((value for value in values if math.isfinite(value)), default=1.0) or 1.0


def shown_at_once(diagnosis: Diagnosis) -> int:
    """Number of pictures that are shown at once: those that explain something, two to six."""
    telling = [k for k, each in enumerate(diagnosis.residuals) if not each.explains < OPEN_PICTURE_SHARE]
    return min(PICTURES, max(2, telling[-1] + 1 if telling else 0), len(diagnosis.residuals))


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
