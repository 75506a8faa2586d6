"""The verdict in whole sentences, each generated from the numbers of the diagnosis."""

from __future__ import annotations

from flexdyn.diagnose.report import digits, words
from flexdyn.diagnose.report.result import Diagnosis
from flexdyn.diagnose.report.sentences import stopped_sentence
from flexdyn.diagnose.report.suspects import CONFIDENCE, ESTABLISHED
from flexdyn.io.text import fill

FINDINGS_IN_ONE_SENTENCE = 2
"""So many findings are all named in one sentence."""


def verdict_sentence(diagnosis: Diagnosis) -> str:
    """The verdict in a sentence or two; of many findings it names the first, of the greatest share."""
    text = fill(
        "diagnose/report/verdict.txt",
        **{**vars(digits), **vars(words)},
        diagnosis=diagnosis,
        model=diagnosis.model,
        firm=[finding for finding in diagnosis.findings if finding.established],
        moved=sum(abs(entry.factor - 1.0) > CONFIDENCE * entry.std for entry in diagnosis.calibration),
        weak=_most_probable(diagnosis),
        so_far=_first_so_far(diagnosis),
        stage_phrase=stage_phrase,
        stopped_sentence=stopped_sentence,
        ESTABLISHED=ESTABLISHED,
        FINDINGS_IN_ONE_SENTENCE=FINDINGS_IN_ONE_SENTENCE,
    )
    return text.rstrip("\n")


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
