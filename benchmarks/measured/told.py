"""What a diagnosis found, as Markdown: findings with their numbers, calibrated numbers, the gap."""

from __future__ import annotations

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
from result_tables import markdown_table

from flexdyn.diagnose import Diagnosis, Finding, Suspect


def findings_text(diagnosis: Diagnosis) -> str:
    """One line a finding, with its probability and what it cannot be told from; or a line that there is none."""
    lines = [f"- {_finding(each)}" for each in diagnosis.findings]
    return "\n".join(lines) if lines else "- No finding."


def gap_text(diagnosis: Diagnosis) -> str:
    """The verdict, and the gap on the windows of the test data."""
    gap = diagnosis.gap_test
    if gap is None:
        return f"Verdict: **{diagnosis.verdict}**."
    return (
        f"Verdict: **{diagnosis.verdict}**. Gap on windows of 0.5 s that took no part, in units of what noise alone "
        f"makes: {gap.before:.2f} as given, {gap.calibrated:.2f} with the file's numbers within their tolerance, "
        f"**{gap.after:.2f} after**; a perfect model reaches {gap.floor:.2f}."
    )


def calibration_table(diagnosis: Diagnosis, digits: int) -> str:
    """Factors of the file's numbers, with their standard deviations."""
    rows = [
        [each.of, each.parameter, f"{each.factor:.{digits}f}", f"{each.std:.{digits}f}"]
        for each in diagnosis.calibration
    ]
    return markdown_table(["number of the file", "", "factor", "std"], rows, text=2)


def _finding(each: Finding) -> str:
    suspect = each.suspect
    numbers = ", ".join(
        f"{key} {x.value:.4g} +- {x.std:.2g} {x.unit if x.unit != '1' else ''}".rstrip()
        for key, x in suspect.parameters.items()
    )
    rivals = ", ".join(f"{_name(rival)}, {rival.probability:.3f}" for rival in each.rivals)
    told = f"**{_name(suspect)}**, probability {each.probability:.3f}: {numbers}."
    return told + (f" Not told apart from: {rivals}." if rivals else "")


def _name(suspect: Suspect) -> str:
    parts = dict.fromkeys(str(part) for part in (suspect.joint, suspect.side, *suspect.place.values()) if part)
    place = ", ".join(parts)
    return f"{suspect.effect.replace('_', ' ')} ({place})"
