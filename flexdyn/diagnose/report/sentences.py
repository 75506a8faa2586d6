"""Sentences of the report except the verdict, each generated from the numbers of the diagnosis."""

from __future__ import annotations

import math

from flexdyn.diagnose.report.digits import likely, percent, probability_text, rounded, times
from flexdyn.diagnose.report.result import Diagnosis
from flexdyn.diagnose.report.suspects import Finding
from flexdyn.diagnose.report.words import capital, finding_phrase, joined, joints_phrase, kind_of


def finding_sentence(diagnosis: Diagnosis, finding: Finding) -> str:
    """A finding with its probability in words and numbers, and that of every name that it may have."""
    phrase = capital(finding_phrase(diagnosis.model, finding, each=True))
    together = "together " if finding.rivals else ""
    words, said = likely(finding.probability), probability_text(finding.probability)
    held = f"{words} ({together}probability {said})" if math.isfinite(finding.probability) else words
    return f"{phrase}: {held}."


def finding_sentences(diagnosis: Diagnosis) -> list[str]:
    """All findings; those of one effect on one side of several joints in one sentence."""
    groups: dict[object, list[Finding]] = {}
    for place, finding in enumerate(diagnosis.findings):
        kind = None if finding.rivals else kind_of(finding.suspect)
        groups.setdefault(kind or place, []).append(finding)
    return [_together(diagnosis, group) for group in groups.values()]


def _together(diagnosis: Diagnosis, group: list[Finding]) -> str:
    """One effect at several joints: the least probable one sets the words."""
    if len(group) == 1:
        return finding_sentence(diagnosis, group[0])
    least = min(finding.probability for finding in group)
    said = probability_text(least)
    held = f"each {likely(least)} (probability {said}{'' if ' ' in said else ' or more'})"
    return f"{capital(joints_phrase([finding.suspect for finding in group]))}: {held}."


def gap_sentence(diagnosis: Diagnosis) -> str:
    """The gap in a line: on the test data where they were opened."""
    gap, data = (diagnosis.gap_test, "test data") if diagnosis.gap_test else (diagnosis.gap_fit, "data of the fit")
    if gap is None:
        return "The gap was not measured." if diagnosis.verdict == "interrupted" else "The gap could not be measured."
    moved = f"from {times(gap.before)} to {times(gap.after)}"
    return f"On the {data}, the gap goes {moved}; noise alone makes {times(gap.floor)}."


def error_sentence(diagnosis: Diagnosis) -> str:
    """The joint whose torque the given model explains worst, before and after; empty where nothing was measured."""
    known = [
        (joint, entry)
        for joint, entry in diagnosis.errors.items()
        if math.isfinite(entry.torque.share_before + entry.torque.share_after)
    ]
    if not known:
        return ""
    joint, entry = max(known, key=lambda each: each[1].torque.share_before)
    worst = ", the joint with the greatest share before," if len(known) > 1 else ""
    return (
        f"At {joint}{worst} the torque error goes from {rounded(entry.torque.before, 2)} to"
        f" {rounded(entry.torque.after, 2)} {entry.torque.unit}, from"
        f" {percent(entry.torque.share_before)} to"
        f" {percent(entry.torque.share_after)} of its torque."
    )


def stopped_sentence(diagnosis: Diagnosis) -> str:
    """Which estimates did not converge; empty where all did."""
    if not diagnosis.stopped:
        return ""
    names = joined(diagnosis.stopped)
    if len(diagnosis.stopped) == 1:
        return f"This estimate stopped before it had converged: {names}."
    return f"These estimates stopped before they had converged: {names}."


def model_sentence(diagnosis: Diagnosis) -> str:
    """Why there is no corrected model; empty where there is one."""
    return f"model.yaml was not written: {diagnosis.no_model}." if diagnosis.no_model else ""


def next_measurements(diagnosis: Diagnosis) -> list[str]:
    """What to measure next, one sentence each; empty if the answer needs no further data."""
    wanted = list(dict.fromkeys(capital(finding.experiment) for finding in diagnosis.findings if finding.experiment))
    if diagnosis.verdict == "interrupted":
        wanted.insert(0, "Run the diagnosis to its end: it needs no new measurement.")
    if diagnosis.verdict in ("unexplained", "partly_explained"):
        places = [(place.joint, place.regime) for place in diagnosis.where] or [
            (each.joint, "") for each in diagnosis.left
        ]
        for joint, regime in places[:2]:
            said = f" ({regime})" if regime not in ("", "everywhere") else ""
            wanted.append(
                f"More motion of {joint}{said}, slower, with the other joints at rest: a law that no catalogue"
                " holds shows best where nothing else moves."
            )
        wanted.append("The same motion again: what does not repeat is no law of the arm's state.")
    if diagnosis.gap_test is None and diagnosis.verdict != "interrupted":
        wanted.append("A second recording of another motion, to test the answer on data that no decision read.")
    return wanted
