"""Effects, places and numbers of a model in plain words that fit into a sentence."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence

from flexdyn.diagnose.report.digits import factor_text, probability_text, rounded
from flexdyn.diagnose.report.origin import RecordingSpan
from flexdyn.diagnose.report.suspects import Finding, Suspect
from flexdyn.effects import registered
from flexdyn.effects.model_error import effect_place
from flexdyn.effects.traits import article
from flexdyn.model.flexible_joint_model import FlexibleJointModel

SIDE_WORDS = {
    "link": "on the link side of",
    "motor": "on the motor side of",
    "sensor": "at the torque sensor of",
    "transmission": "in the transmission of",
    "total": "on motor and link of",
}
UNIT_OF_SIGNAL = {"q": "{}", "theta": "{}", "v": "{}/s", "omega": "{}/s"}
"""Units of a channel by its signal, of the joint's angle or length; of all others see `channel_unit`."""


def finding_phrase(model: FlexibleJointModel, finding: Finding, *, each: bool = False) -> str:
    """``Stribeck friction or presliding friction on the motor side of elbow``: an effect and what it could be.

    Args:
        model: whose numbers may be wrong.
        finding: to be named.
        each: with the probability of each single name, if there are several.
    """
    several = each and bool(finding.rivals)
    here = where_phrase(model, finding.suspect)
    alike = in_one_place(model, finding)
    others = [
        f"{suspect_phrase(model, rival)}{_own_probability(rival, several)}"
        for rival in finding.rivals
        if rival not in alike
    ]
    if not alike:
        return ", or ".join(
            [f"{suspect_phrase(model, finding.suspect)}{_own_probability(finding.suspect, several)}", *others]
        )
    names = " or ".join(
        f"{effect_name(one.effect)}{_own_probability(one, several)}" for one in (finding.suspect, *alike)
    )
    return ", or ".join([f"{article(effect_name(finding.suspect.effect))}{names} {here}".strip(), *others])


def in_one_place(model: FlexibleJointModel, finding: Finding) -> list[Suspect]:
    """Rivals that act where the finding acts; none of a wrong number."""
    here = where_phrase(model, finding.suspect)
    rivals = [] if is_number(finding.suspect) else finding.rivals
    return [rival for rival in rivals if where_phrase(model, rival) == here]


def suspect_phrase(model: FlexibleJointModel, suspect: Suspect) -> str:
    """An effect and where it acts, in words that fit into a sentence."""
    where = where_phrase(model, suspect)
    if is_number(suspect):
        factor = suspect.parameters.get("factor")
        return f"a wrong {where}{'' if factor is None else f' ({factor_text(factor.value)})'}"
    return f"{article(effect_name(suspect.effect))}{effect_name(suspect.effect)} {where}".strip()


def plain_phrase(phrase: str) -> str:
    """A phrase without its article, the first letter a capital one."""
    return capital(phrase.removeprefix("a ").removeprefix("an "))


def grouped_phrases(model: FlexibleJointModel, suspects: Iterable[Suspect]) -> list[str]:
    """Effects in few words: one effect on one side of several joints is one phrase."""
    groups: dict[object, list[Suspect]] = {}
    for place, suspect in enumerate(suspects):
        groups.setdefault(kind_of(suspect) or place, []).append(suspect)
    return [suspect_phrase(model, group[0]) if len(group) == 1 else joints_phrase(group) for group in groups.values()]


def kind_of(suspect: Suspect) -> tuple[str, str | None] | None:
    """Effect and side, which others at other joints may share; None: where it acts needs more words."""
    return None if suspect.joint is None or suspect.place else (suspect.effect, suspect.side)


def joints_phrase(suspects: Sequence[Suspect]) -> str:
    """``Coulomb friction on the motor side of shoulder and elbow``, of one effect at several joints."""
    where = place_phrase(joined([str(each.joint) for each in suspects]), suspects[0].side)
    return f"{effect_name(suspects[0].effect)} {where}"


def joined(phrases: Sequence[str]) -> str:
    """``one``, ``one and two``, ``one, two and three``."""
    *first, last = phrases
    return f"{', '.join(first)} and {last}" if first else last


def is_number(suspect: Suspect) -> bool:
    """Whether it is a number of the model file that is wrong, which reads in another order."""
    return names_number(suspect.effect)


def names_number(effect: str) -> bool:
    """Whether an effect of this name says that a number of the model file is wrong."""
    return effect in registered() and registered()[effect].stage == "model"


def effect_name(effect: str) -> str:
    """``stribeck_friction`` as it is written in a sentence: as its class says, else with spaces."""
    kind = registered().get(effect)
    return (kind.words if kind else "") or effect.replace("_", " ")


def capital(text: str) -> str:
    """As a title: the first letter a capital one, the others as they are."""
    return text[:1].upper() + text[1:]


def where_phrase(model: FlexibleJointModel, suspect: Suspect) -> str:
    """Where an effect acts: the joint's side, the channel, the frame, or the number that is wrong."""
    place = suspect.place
    if "channel" in place:
        return f"on channel {place['channel']}"
    if is_number(suspect):
        return number_phrase(model, place.get("of", suspect.joint or ""), place.get("parameter", "number"))
    if suspect.joint is None:
        return f"at frame {place['frame']}" if "frame" in place else "at the end of the arm"
    other = f", driven by {place['other']}" if "other" in place else ""
    return f"{place_phrase(suspect.joint, suspect.side)}{other}"


def place_phrase(joint: str, side: str | None) -> str:
    """``on the motor side of elbow``."""
    return f"{SIDE_WORDS.get(side or '', 'on')} {joint}"


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


def channel_unit(model: FlexibleJointModel, channel: str) -> str:
    """Unit of a channel; empty where it is not known."""
    signal, _, joint = channel.partition(".")
    if joint not in model.joint_names:
        return ""
    if signal in UNIT_OF_SIGNAL:
        return UNIT_OF_SIGNAL[signal].format(model.robot.angle_unit(joint))
    return model.robot.torque_unit(joint) if signal.startswith("tau") else ""


def noise_lines(model: FlexibleJointModel, span: RecordingSpan) -> list[str]:
    """The noise of each channel with its unit."""
    return [f"{name} {rounded(level, 2)} {channel_unit(model, name)}".strip() for name, level in span.noise.items()]


def _own_probability(suspect: Suspect, told: bool) -> str:
    """A name's own probability, in brackets."""
    if not told or math.isnan(suspect.probability):
        return ""
    return f" ({probability_text(suspect.probability)})"
