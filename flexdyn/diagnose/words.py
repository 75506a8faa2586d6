"""A diagnosis in plain words: what was found, where, and what is left of the gap."""

from __future__ import annotations

import math
import re

from flexdyn.diagnose.result import Diagnosis, Finding, Gap, Number, Suspect
from flexdyn.effects.model_error import effect_place
from flexdyn.model import FlexibleJointModel

FEW = 2
"""So many findings are all named in one sentence."""
UNCOUNTED = ("friction", "damping", "elasticity", "drag", "backlash", "hysteresis", "ripple", "eccentricity")
"""What an effect's name ends with where it takes no article."""
UNCHANGED = 1e-3
"""A change of less than so many percent is none."""
CONFIDENCE = 1.96
"""Standard deviations on either side that hold 95 % of a normal distribution."""


def verdict_sentence(diagnosis: Diagnosis) -> str:
    """The verdict in one sentence; of many findings it names the first, which has the greatest share of the gap."""
    phrases = causes(diagnosis)
    if diagnosis.verdict == "no_discrepancy":
        moved = sum(abs(entry.factor - 1.0) > CONFIDENCE * entry.std for entry in diagnosis.calibration)
        once = (
            f", once {counted(moved, 'number')} of the model {'has' if moved == 1 else 'have'} moved within tolerance"
        )
        return f"Model and measurement agree: what is left between them is noise{once if moved else ''}."
    part = "The disagreement" if diagnosis.verdict == "explained" else "Part of the disagreement"
    rest = "" if diagnosis.verdict == "explained" else "; what is left, no effect of the catalogue accounts for"
    if len(phrases) > FEW:
        return f"{part} has {len(phrases)} causes, above all {phrases[0]}{rest}."
    if phrases or not rest:
        names = " and by ".join(phrases) or "numbers that moved within their tolerance"
        return f"{part} is explained by {names}{rest}."
    where = (
        f", most of all {place_phrase(diagnosis.where[0].joint, diagnosis.where[0].side)}" if diagnosis.where else ""
    )
    return f"Model and measurement disagree{where}, and no effect of the catalogue accounts for it."


def causes(diagnosis: Diagnosis) -> list[str]:
    """Every finding in words that fit into a sentence."""
    return [finding_phrase(diagnosis.model, finding) for finding in diagnosis.findings]


def gap_sentence(diagnosis: Diagnosis) -> str:
    """The gap in a line: on data that took no part in the fit where there are any."""
    gap, data = (diagnosis.check, "not used in the fit") if diagnosis.check else (diagnosis.fit, "of the fit")
    if gap is None:
        return "The gap could not be measured."
    moved = f"from {times(gap.before)} to {times(gap.after)}"
    return f"On data {data}, the gap goes {moved}; noise alone makes {times(gap.floor)}."


def gap_stages(gap: Gap) -> list[tuple[str, float]]:
    """What each number of a gap is of."""
    return [("as given", gap.before), ("calibrated", gap.calibrated), ("corrected", gap.after)]


def finding_phrase(model: FlexibleJointModel, finding: Finding) -> str:
    """``Stribeck friction or presliding friction on the motor side of elbow``: an effect and what it could be."""
    here = where_phrase(model, finding.suspect)
    alike = [rival for rival in finding.rivals if _is_named_by_place(rival) and where_phrase(model, rival) == here]
    if not _is_named_by_place(finding.suspect):
        alike = []
    first = " or ".join(effect_name(suspect.effect) for suspect in (*alike, finding.suspect)[::-1])
    others = [suspect_phrase(model, rival) for rival in finding.rivals if rival not in alike]
    named = f"{_article(finding.suspect.effect)}{first} {here}" if alike else suspect_phrase(model, finding.suspect)
    return ", or ".join([named.strip(), *others])


def suspect_phrase(model: FlexibleJointModel, suspect: Suspect) -> str:
    """An effect and where it acts, in words that fit into a sentence."""
    where = where_phrase(model, suspect)
    if not _is_named_by_place(suspect):
        factor = suspect.parameters.get("factor")
        return f"a wrong {where}{'' if factor is None else f' ({relative(factor.value)})'}"
    return f"{_article(suspect.effect)}{effect_name(suspect.effect)} {where}".strip()


def _is_named_by_place(suspect: Suspect) -> bool:
    """Whether it reads "name of the effect, where it acts"."""
    return suspect.effect != "parameter_error"


def _article(effect: str) -> str:
    if effect.endswith(UNCOUNTED):
        return ""
    return "an " if effect[:1] in "aeiou" else "a "


def effect_name(effect: str) -> str:
    """``stribeck_friction`` as it is written in a sentence."""
    return re.sub(r"\b(stribeck|coulomb)\b", lambda name: name[0].capitalize(), effect.replace("_", " "))


def capital(text: str) -> str:
    """As a title: the first letter a capital one, the others as they are."""
    return text[:1].upper() + text[1:]


def where_phrase(model: FlexibleJointModel, suspect: Suspect) -> str:
    """Where an effect acts: the joint's side, the channel, the frame, or the number that is wrong."""
    place = suspect.place
    if "channel" in place:
        return f"on channel {place['channel']}"
    if suspect.effect == "parameter_error":
        return number_phrase(model, place.get("of", suspect.joint or ""), place.get("parameter", "number"))
    if suspect.joint is None:
        return f"at frame {place['frame']}" if "frame" in place else "at the end of the arm"
    other = f", driven by {place['other']}" if "other" in place else ""
    return f"{place_phrase(suspect.joint, suspect.side)}{other}"


def place_phrase(joint: str, side: str | None) -> str:
    """``on the motor side of elbow``."""
    words = {"link": "on the link side of", "motor": "on the motor side of", "sensor": "at the torque sensor of"}
    words |= {"transmission": "in the transmission of", "total": "on motor and link together of"}
    return f"{words.get(side or '', 'on')} {joint}"


def number_phrase(model: FlexibleJointModel, of: str, parameter: str) -> str:
    """A number of the model file: ``stiffness of elbow``, ``level of coulomb friction on the motor side of elbow``."""
    word = parameter.removeprefix("link_").replace("_", " ").replace("urdf", "URDF")
    word = {"com": "centre of mass"}.get(word, word)
    place = effect_place(of)
    if place is None or place >= len(model.effects):
        return f"{word} of {of}"
    effect = model.effects[place]
    joint, side = getattr(effect, "joint", None), getattr(effect, "side", None)
    return f"{word} of {effect_name(effect.name)}{f' {place_phrase(joint, side)}' if joint else ''}"


def times(value: float) -> str:
    """A gap in units of noise."""
    if not math.isfinite(value):
        return "unknown" if math.isnan(value) else "beyond measure"
    return f"{value:.0f}" if value >= 100.0 else f"{value:.1f}" if value >= 10.0 else f"{value:.2f}"


def relative(factor: float) -> str:
    """A factor as what it changes: ``+23 %``, ``none``; from 3 on as it is."""
    if not math.isfinite(factor):
        return "unknown"
    if factor >= 3.0 or factor <= 1.0 / 3.0:
        return f"{factor:.3g} times what is given"
    size, sign = abs(100.0 * (factor - 1.0)), "\N{MINUS SIGN}" if factor < 1.0 else "+"
    if size < UNCHANGED:
        return "none"
    return f"{sign}{size:.0f} %" if size >= 10.0 else f"{sign}{size:.2g} %"


def value_text(value: float, std: float) -> str:
    """A number with the digits that its uncertainty leaves it."""
    if not math.isfinite(value):
        return "unknown"
    if not math.isfinite(std) or std <= 0.0:
        return _signed(f"{value:.4g}")
    size, last = (math.floor(math.log10(x)) for x in (max(abs(value), std), std))
    if -3 <= size < 5:
        return _signed(f"{value:.{max(0, 1 - last)}f}")
    return _signed(f"{value:.{size - last + 1}e}")


def estimate_text(number: Number) -> str:
    """A number with its standard deviation and its unit."""
    value, std = value_text(number.value, number.std), ""
    if math.isfinite(number.value) and math.isfinite(number.std) and number.std > 0.0:
        decimals = len(value.partition(".")[2])
        plain = "e" not in value and decimals < 9
        std = f" \N{PLUS-MINUS SIGN} {number.std:.{decimals}f}" if plain else f" \N{PLUS-MINUS SIGN} {number.std:.1e}"
    return f"{value}{_signed(std)} {unit_text(number.unit)}".strip()


def interval_text(number: Number) -> str:
    """The 95 % interval of a number, with its unit."""
    if not (math.isfinite(number.value) and math.isfinite(number.std)):
        return "not known"
    if number.std <= 0.0:
        return "chosen among a few, not measured"
    ends = (number.value + sign * CONFIDENCE * number.std for sign in (-1.0, 1.0))
    return f"{' to '.join(value_text(end, number.std) for end in ends)} {unit_text(number.unit)}".strip()


def unit_text(unit: str) -> str:
    """A unit as it stands behind a number; none where it is 1."""
    return "" if unit == "1" else unit


def counted(count: int, noun: str) -> str:
    """``1 number``, ``2 numbers``."""
    return f"{count} {noun}{'' if count == 1 else 's'}"


def next_measurements(diagnosis: Diagnosis) -> list[str]:
    """What to measure next, a sentence each; nothing where the answer stands as it is."""
    wanted = list(dict.fromkeys(capital(finding.experiment) for finding in diagnosis.findings if finding.experiment))
    if diagnosis.verdict == "unexplained":
        for place in diagnosis.where[:2]:
            regime = f" ({place.regime})" if place.regime else ""
            wanted.append(
                f"More motion of {place.joint}{regime}, slower, with the other joints at rest: what no catalogue holds"
                " shows best where nothing else moves."
            )
        wanted.append("The same motion once more: what does not come back the same is no law of the arm's state.")
    if diagnosis.check is None:
        wanted.append("A second recording of another motion, to check the answer on data that took no part in the fit.")
    return wanted


def _signed(text: str) -> str:
    return text.replace("-", "\N{MINUS SIGN}")
