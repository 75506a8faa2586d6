"""A finding in report.html: its numbers, its law, and why it has this name."""

from __future__ import annotations

import math
from html import escape

from flexdyn.diagnose.nesting import is_simpler
from flexdyn.diagnose.pictures import law_picture
from flexdyn.diagnose.result import Finding, Number, Suspect, Tried
from flexdyn.diagnose.words import (
    capital,
    effect_name,
    estimate_text,
    interval_text,
    relative,
    suspect_phrase,
    times,
    unit_text,
    value_text,
    where_phrase,
)
from flexdyn.effects import catalogue
from flexdyn.model import FlexibleJointModel

SHOWN = 4
"""Names that stand beside the one that was chosen."""


def finding_article(model: FlexibleJointModel, place: int, finding: Finding) -> str:
    """Everything about one finding.

    Args:
        model: the corrected one.
        place: of the finding, counted from 1.
        finding: to be told.
    """
    suspect = finding.suspect
    picture = law_picture(suspect, model)
    drawn = ""
    if picture is not None:
        what = f"The law of {effect_name(suspect.effect)} with the numbers found"
        drawn = f'<figure><img src="{picture}" alt="{escape(what)}"><figcaption>{escape(what)}.</figcaption></figure>'
    told = f"{_title(model, place, finding)}{_numbers(finding)}<h4>Why this name</h4>{_evidence(finding)}"
    told += _tried(model, finding) + _rivals(model, finding)
    return f"<article{'' if drawn else ' class=plain'}><div>{told}</div>{drawn}</article>"


def _title(model: FlexibleJointModel, place: int, finding: Finding) -> str:
    suspect = finding.suspect
    kind = catalogue().get(suspect.effect)
    where = where_phrase(model, suspect)
    wrong = suspect.effect == "parameter_error"
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
    rows = "".join(_number(name, number) for name, number in suspect.parameters.items())
    top = '<tr><th>parameter</th><th class="n">value</th><th>95 % interval</th></tr>'
    assumed = f"<h4>If it is {escape(effect_name(suspect.effect))}</h4>" if finding.rivals else ""
    return f'{assumed}<div class="wide"><table>{top}{rows}</table></div>'


def _number(name: str, number: Number) -> str:
    unit = escape(unit_text(number.unit))
    said = f' <span class="soft">({escape(relative(number.value))})</span>' if name == "factor" else ""
    return (
        f'<tr><td>{escape(name)}</td><td class="n"><b>{value_text(number.value, number.std)}</b> {unit}{said}</td>'
        f"<td>{escape(interval_text(number))}</td></tr>"
    )


def _evidence(finding: Finding) -> str:
    told = []
    if math.isfinite(finding.delta_bic):
        strength = "10 is strong evidence already" if finding.delta_bic >= 10.0 else "less than 10, which is weak"
        told.append(
            f"Without it the model explains the data of the fit worse by &Delta;BIC = {_grouped(finding.delta_bic)}"
            f" ({strength})."
        )
    if math.isfinite(finding.check_gain):
        told.append(
            f"On data that took no part in the fit, {100.0 * finding.check_gain:.0f} % of the gap goes with it."
        )
    if not finding.rivals:
        told.append("No other effect of the catalogue explains these data as well.")
    return f"<ul>{''.join(f'<li>{text}</li>' for text in told)}</ul>"


def _tried(model: FlexibleJointModel, finding: Finding) -> str:
    """The other names that were tried for it: how much worse they explain both kinds of data."""
    others = [each for each in finding.tried if not _same(each.suspect, finding.suspect)]
    if not others:
        return ""
    own = next((each for each in finding.tried if _same(each.suspect, finding.suspect)), None)
    rows = "" if own is None else f"<tr><td><b>{_name(model, own.suspect)}</b></td>{_marks(own)}</tr>"
    for each in others[:SHOWN]:
        same = (each.suspect.joint, each.suspect.side) == (finding.suspect.joint, finding.suspect.side)
        wider = same and is_simpler(finding.suspect.effect, each.suspect.effect)
        note = f' <span class="soft">({_more(each)})</span>' if wider else ""
        rows += f"<tr><td>{_name(model, each.suspect)}{note}</td>{_marks(each)}</tr>"
    top = (
        '<tr><th>tried in its place, when it was chosen</th><th class="n">worse by &Delta;BIC, data of the fit</th>'
        '<th class="n">gap, data not used</th></tr>'
    )
    return f'<div class="wide"><table class="tried">{top}{rows}</table></div>'


def _more(wider: Tried) -> str:
    """What is said of a law that contains the one that was chosen."""
    if wider.behind < 0.0:
        return "contains it; the rest of it was looked for afterwards"
    return "contains it, and is not needed"


def _same(one: Suspect, other: Suspect) -> bool:
    return (one.effect, one.joint, one.side, one.place) == (other.effect, other.joint, other.side, other.place)


def _name(model: FlexibleJointModel, suspect: Suspect) -> str:
    return escape(capital(suspect_phrase(model, suspect).removeprefix("a ").removeprefix("an ")))


def _marks(entry: Tried) -> str:
    """How a name did: worse by so much, better where negative."""
    sign = "\N{MINUS SIGN}" if entry.behind < 0.0 else "+"
    behind = f"{sign}{_grouped(abs(entry.behind))}" if entry.behind else "0"
    gap = "not asked" if math.isnan(entry.gap) else times(entry.gap)
    return f'<td class="n">{behind}</td><td class="n">{gap}</td>'


def _grouped(value: float) -> str:
    """A large number in groups of three digits."""
    return f"{value:,.0f}".replace(",", "\N{NARROW NO-BREAK SPACE}")


def _rivals(model: FlexibleJointModel, finding: Finding) -> str:
    if not finding.rivals:
        return ""
    rows = "".join(f"<li>{escape(_rival(model, rival))}</li>" for rival in finding.rivals)
    apart = finding.experiment and f"<p><b>What would tell them apart:</b> {escape(finding.experiment)}</p>"
    return f'<div class="or"><p><b>These data allow as well:</b></p><ul>{rows}</ul>{apart}</div>'


def _rival(model: FlexibleJointModel, rival: Suspect) -> str:
    numbers = ", ".join(f"{name} {estimate_text(number)}" for name, number in rival.parameters.items())
    return f"{suspect_phrase(model, rival)}{f' ({numbers})' if numbers else ''}"
