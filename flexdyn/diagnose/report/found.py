"""Part of report.html: the findings, their numbers, their laws, and the evidence for each name."""

from __future__ import annotations

import math
from html import escape

from flexdyn.diagnose.report.digits import (
    counted,
    estimate_text,
    evidence_text,
    interval_text,
    likely,
    log_text,
    percent,
    probability_text,
    relative,
    unit_text,
    value_text,
)
from flexdyn.diagnose.report.html import folded, section, table
from flexdyn.diagnose.report.law import law_picture
from flexdyn.diagnose.report.ranks import Ranks, beyond, ranks
from flexdyn.diagnose.report.result import Diagnosis
from flexdyn.diagnose.report.suspects import ESTABLISHED, Finding, Number, Suspect
from flexdyn.diagnose.report.words import (
    capital,
    effect_name,
    finding_phrase,
    grouped_phrases,
    is_number,
    joined,
    plain_phrase,
    suspect_phrase,
    where_phrase,
)
from flexdyn.effects import catalogue

FINDINGS_OPEN = 4
"""Findings that are told in full at once; of more there is a table, and the others are folded away."""


def findings(diagnosis: Diagnosis) -> str:
    """Every finding: what, how much, and why this name."""
    if not diagnosis.findings:
        return ""
    shown = [finding_article(diagnosis, k, entry) for k, entry in enumerate(diagnosis.findings, start=1)]
    body = _overview(diagnosis) if len(shown) > 1 else ""
    body += "".join(shown[:FINDINGS_OPEN])
    if shown[FINDINGS_OPEN:]:
        body += folded(f"{counted(len(shown) - FINDINGS_OPEN, 'more finding')} in full", "".join(shown[FINDINGS_OPEN:]))
    return section("What was found", body, "findings")


def _overview(diagnosis: Diagnosis) -> str:
    """One line a finding."""
    rows = []
    for k, finding in enumerate(diagnosis.findings, start=1):
        names = escape(plain_phrase(finding_phrase(diagnosis.model, finding)))
        numbers = ", ".join(f"{name} {estimate_text(number)}" for name, number in finding.suspect.parameters.items())
        sure = "" if finding.established else '<br><span class="soft">not established</span>'
        factor = finding.log_bayes_factor
        share = "" if diagnosis.shares is None else percent(diagnosis.shares.findings[k - 1])
        evidence = ["" if math.isnan(factor) else log_text(factor), share]
        rows.append([f"{k}", names, escape(numbers), probability_text(finding.probability) + sure, *evidence])
    heads = (
        "",
        "finding",
        "estimates<br>[95 % interval]",
        "probability",
        "log Bayes<br>factor",
        "share of the<br>test gap",
    )
    return table(heads, rows, numbers=(3, 4, 5), name="overview")


def finding_article(diagnosis: Diagnosis, place: int, finding: Finding) -> str:
    """Everything about one finding.

    Args:
        diagnosis: that it belongs to.
        place: of the finding, counted from 1.
        finding: to be told.
    """
    suspect = finding.suspect
    picture = law_picture(suspect, diagnosis.model)
    drawn = ""
    if picture is not None:
        what = f"The law of {effect_name(suspect.effect)} with the numbers found"
        drawn = f'<figure><img src="{picture}" alt="{escape(what)}"><figcaption>{escape(what)}.</figcaption></figure>'
    told = f"{_title(diagnosis, place, finding)}{_numbers(finding)}<h4>Evidence</h4>{_evidence(diagnosis, finding)}"
    return f"<article{'' if drawn else ' class=plain'}><div>{told}{_rivals(diagnosis, finding)}</div>{drawn}</article>"


def _title(diagnosis: Diagnosis, place: int, finding: Finding) -> str:
    suspect, model = finding.suspect, diagnosis.model
    kind = catalogue().get(suspect.effect)
    where = where_phrase(model, suspect)
    wrong = is_number(suspect)
    alike = [] if wrong else [rival for rival in finding.rivals if where_phrase(model, rival) == where]
    names = [f"wrong {where}" if wrong else effect_name(suspect.effect), *(effect_name(each.effect) for each in alike)]
    name = " or ".join(dict.fromkeys(names))
    law = f"<p><code>{escape(kind.law)}</code></p>" if kind is not None and kind.law else ""
    elsewhere = [f"or {suspect_phrase(model, rival)}" for rival in finding.rivals if rival not in alike]
    told = ", ".join([*([] if wrong else [where]), *elsewhere])
    return f"<h3>{place}. {escape(capital(name))}</h3>{f'<p>{escape(told)}</p>' if told else ''}{law}"


def _numbers(finding: Finding) -> str:
    suspect = finding.suspect
    if not suspect.parameters:
        return ""
    rows = [_number(name, number) for name, number in suspect.parameters.items()]
    assumed = f"<h4>If it is {escape(effect_name(suspect.effect))}</h4>" if finding.rivals else ""
    return assumed + table(("parameter", "estimate", "standard error", "95 % interval"), rows)


def _number(name: str, number: Number) -> list[str]:
    unit = escape(unit_text(number.unit))
    said = f' <span class="soft">({escape(relative(number.value))})</span>' if name == "factor" else ""
    known = math.isfinite(number.std) and number.std > 0.0
    spread = (
        f"{value_text(number.std, number.std)} {unit}" if known else "not known" if math.isnan(number.std) else "none"
    )
    value = f"<b>{value_text(number.value, number.std)}</b> {unit}{said}"
    return [escape(name), value, spread, escape(interval_text(number))]


def _evidence(diagnosis: Diagnosis, finding: Finding) -> str:
    said, told = probability_text(finding.probability), []
    if math.isfinite(finding.probability):
        one_of = " that one of these names is right" if finding.rivals else ""
        told.append(f"Posterior probability {said}{one_of}: {likely(finding.probability)}{_short(finding)}.")
    if not math.isnan(finding.log_bayes_factor):
        told.append(
            "The best structure with it against the best without it: log Bayes factor"
            f" {evidence_text(finding.log_bayes_factor)}."
        )
    if math.isfinite(finding.test_gain):
        told.append(_missed(finding.test_gain))
    told += _compared(diagnosis, finding)
    return f"<ul>{''.join(f'<li>{escape(text)}</li>' for text in told)}</ul>"


def _missed(gain: float) -> str:
    """What its absence would do on the test data."""
    if gain < 0.0:
        return f"If it alone is left out, the improvement on the test data grows by {percent(-gain)}."
    return f"If it alone is left out, {percent(gain)} of the improvement on the test data is lost."


def _short(finding: Finding) -> str:
    """What is said of a finding that is not probable enough."""
    return "" if finding.established else f", not established: {ESTABLISHED} is required"


def _compared(diagnosis: Diagnosis, finding: Finding) -> list[str]:
    """What the structures say: how many hold it, and the best explanation that does without it."""
    found = ranks(diagnosis.structures, finding.names)
    if not found.among:
        return []
    names, them = ("one of these names", "them") if finding.rivals else ("it", "it")
    if found.other is None:
        return [f"Every one of the {found.among} ranked structures holds {names}."]
    if found.best is None:
        return [f"None of the {found.among} ranked structures holds {names}."]
    return [
        f"{len(found.holding)} of the {found.among} ranked structures hold {names}. {_without(diagnosis, found, them)}"
    ]


def _without(diagnosis: Diagnosis, found: Ranks, them: str) -> str:
    """The best structure without it: what it has in its place, and how far its evidence is behind."""
    best, other = found.best, found.other
    if best is None or other is None:
        return ""
    behind = best.log_evidence - other.log_evidence
    instead = grouped_phrases(diagnosis.model, beyond(other, best))
    names = joined(instead) if instead else "nothing"
    how = f"lower by {log_text(behind)}" if behind >= 0.0 else f"higher by {log_text(-behind)}"
    said = probability_text(other.probability)
    return f"The best one without {them} has {names} instead; its log evidence is {how}, its probability {said}."


def _rivals(diagnosis: Diagnosis, finding: Finding) -> str:
    if not finding.rivals:
        return ""
    rows = "".join(f"<li>{escape(_rival(diagnosis, each))}</li>" for each in finding.names)
    apart = finding.experiment and f"<p><b>What would tell them apart:</b> {escape(finding.experiment)}</p>"
    return f'<div class="or"><p><b>These data do not tell which of these it is:</b></p><ul>{rows}</ul>{apart}</div>'


def _rival(diagnosis: Diagnosis, rival: Suspect) -> str:
    numbers = ", ".join(f"{name} {estimate_text(number)}" for name, number in rival.parameters.items())
    known = math.isfinite(rival.probability)
    said = f": probability {probability_text(rival.probability)}" if known else ""
    return f"{suspect_phrase(diagnosis.model, rival)}{f' ({numbers})' if numbers else ''}{said}"
