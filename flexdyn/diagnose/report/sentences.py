"""Sentences of the report, generated from the numbers of the diagnosis; those of the verdict are in verdict.txt."""

from __future__ import annotations

import math
from typing import Any

from flexdyn.diagnose.constants import ESTABLISHED
from flexdyn.diagnose.report import digits, words
from flexdyn.diagnose.report.result import Diagnosis
from flexdyn.diagnose.report.suspects import CONFIDENCE, Finding
from flexdyn.io.text import fill

FINDINGS_IN_ONE_SENTENCE = 2
"""So many findings are all named in one sentence."""


def finding_sentences(diagnosis: Diagnosis) -> list[str]:
    """All findings; those of one effect on one side of several joints in one sentence."""
    groups: dict[object, list[Finding]] = {}
    for place, finding in enumerate(diagnosis.findings):
        kind = None if finding.rivals else words.kind_of(finding.suspect)
        groups.setdefault(kind or place, []).append(finding)
    return [filled_template("finding", diagnosis, group=group) for group in groups.values()]


def gap_sentence(diagnosis: Diagnosis) -> str:
    """The gap in a line: on the test data where they were opened."""
    return filled_template("gap", diagnosis)


def error_sentence(diagnosis: Diagnosis) -> str:
    """The joint whose torque the given model explains worst, before and after; empty where nothing was measured."""
    errors = [(joint, entry.torque) for joint, entry in diagnosis.errors.items()]
    errors = [each for each in errors if math.isfinite(each[1].share_before + each[1].share_after)]
    return filled_template("torque_error", diagnosis, errors=errors)


def filled_template(name: str, diagnosis: Diagnosis, **known: Any) -> str:
    """What a template of text makes of a diagnosis.

    Args:
        name: of the template.
        diagnosis: as it calls it; `model` is its model.
        known: what else its names stand for, besides what `digits` and `words` offer.
    """
    own = {"diagnosis": diagnosis, "model": diagnosis.model, "isfinite": math.isfinite, "isnan": math.isnan}
    offered = {**vars(digits), **vars(words), **own, **known}
    return fill(f"diagnose/report/{name}.txt", **offered).rstrip("\n")


def stopped_sentence(diagnosis: Diagnosis) -> str:
    """Which estimates did not converge; empty where all did."""
    if not diagnosis.stopped:
        return ""
    one = len(diagnosis.stopped) == 1
    which, it = ("This estimate", "it") if one else ("These estimates", "they")
    return f"{which} stopped before {it} had converged: {words.joined(diagnosis.stopped)}."


def model_sentence(diagnosis: Diagnosis) -> str:
    """Why there is no corrected model; empty where there is one."""
    return f"model.yaml was not written: {diagnosis.no_model}." if diagnosis.no_model else ""


def next_measurements(diagnosis: Diagnosis) -> list[str]:
    """What to measure next, one sentence each; empty if the answer needs no further data."""
    wanted = list(dict.fromkeys(words.capital(each.experiment) for each in diagnosis.findings if each.experiment))
    if diagnosis.verdict == "interrupted":
        wanted.insert(0, "Run the diagnosis to its end: it needs no new measurement.")
    if diagnosis.verdict in ("unexplained", "partly_explained"):
        places = [(e.joint, f" ({e.regime})" if e.regime not in ("", "everywhere") else "") for e in diagnosis.where]
        wanted += [
            f"More motion of {joint}{regime}, slower, with the other joints at rest: a law that the catalogue lacks"
            " is seen best where nothing else moves."
            for joint, regime in (places or [(each.joint, "") for each in diagnosis.left])[:2]
        ]
        wanted.append("The same motion again: a residual that depends only on the arm's state repeats.")
    if diagnosis.gap_test is None and diagnosis.verdict != "interrupted":
        wanted.append("A second recording of another motion, to test the answer on data that no decision has used.")
    return wanted


def verdict_sentence(diagnosis: Diagnosis) -> str:
    """The verdict in a sentence or two; of many findings it names the first, of the greatest share."""
    return filled_template(
        "verdict",
        diagnosis,
        firm=[finding for finding in diagnosis.findings if finding.established],
        moved=sum(abs(entry.factor - 1.0) > CONFIDENCE * entry.std for entry in diagnosis.calibration),
        weak=_most_probable(diagnosis),
        so_far=_first_so_far(diagnosis),
        stage_phrase=stage_phrase,
        stopped_sentence=stopped_sentence,
        ESTABLISHED=ESTABLISHED,
        FINDINGS_IN_ONE_SENTENCE=FINDINGS_IN_ONE_SENTENCE,
    )


def _most_probable(diagnosis: Diagnosis) -> tuple[float, str] | None:
    """Probability and name of the best one if none was established."""
    model = diagnosis.model
    named = [(each.probability, words.finding_phrase(model, each)) for each in diagnosis.findings]
    named += [(each.probability, words.suspect_phrase(model, each.suspect)) for each in diagnosis.considered]
    weak = [each for each in named if each[0] < ESTABLISHED]
    return max(weak, key=lambda entry: entry[0]) if weak and len(weak) == len(named) else None


def stage_phrase(stage: str) -> str:
    """``comparing structures, pass 2 of at most 5``: a stage within a sentence."""
    return stage.replace(": ", ", ").replace(" (", ", stage ").removesuffix(")")


def _first_so_far(diagnosis: Diagnosis) -> str:
    """The most probable structure of a comparison that had not ended; empty if there is none."""
    if diagnosis.findings or not diagnosis.structures:
        return ""
    first = diagnosis.structures[0].effects
    names = words.grouped_phrases(diagnosis.model, first)
    if len(names) > FINDINGS_IN_ONE_SENTENCE:
        return f"a set of {len(first)} effects, listed below,"
    return words.joined(names) if names else "no effect at all"
