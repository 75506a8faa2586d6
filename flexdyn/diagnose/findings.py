"""From a fitted hypothesis to findings in the words of the report."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence

from flexdyn.diagnose.candidates import Candidate
from flexdyn.diagnose.nesting import is_nested
from flexdyn.diagnose.numbers import IN_TOLERANCE, FileNumber
from flexdyn.diagnose.refine import Refined
from flexdyn.diagnose.result import Calibration, Finding, Number, Suspect, Tried
from flexdyn.diagnose.stage import Alternative
from flexdyn.effects import Effect, JointElasticity, unit_for
from flexdyn.effects.model_error import effect_place
from flexdyn.model import FlexibleJointModel

PLACES = ("channel", "other", "frame", "of", "parameter")
AWAY = 3.0
"""Standard deviations by which an effect's size must differ from none."""
SIDES = {"rotor_inertia": "motor", "stiffness": "transmission", "damping": "transmission"}


def finding(
    model: FlexibleJointModel, added: Candidate | None, rivals: Sequence[Candidate], last: Refined, gain: float
) -> Finding | None:
    """One confirmed candidate with its final numbers; None where the last fit left nothing of it."""
    if added is None:
        return None
    if added.number is not None:
        suspect = wrong_number(model, added.number, last)
    else:
        effect = last.matching(added.effect)
        std = last.effect_std()
        suspect = named(model, effect, std) if effect is not None and _is_there(effect, std) else None
    if suspect is None:
        return None
    others = tuple(
        rival
        for rival in (suspected(model, each) for each in rivals)
        if not (rival.joint == suspect.joint and rival.side == suspect.side and is_nested(rival.effect, suspect.effect))
        and (rival.effect, rival.joint, rival.side, rival.place)
        != (suspect.effect, suspect.joint, suspect.side, suspect.place)
    )
    return Finding(suspect, float(added.drop), float(gain), others, "" if not others else _experiment(suspect, others))


def _is_there(effect: Effect, std: Mapping[tuple[Effect, str], float]) -> bool:
    """Whether the numbers that make an effect do something are away from those at which it does nothing."""
    if isinstance(effect, JointElasticity):  # which does nothing where it has no compliance
        return effect.stiffness > AWAY * std.get((effect, "stiffness"), 0.0)
    return not effect.neutral or any(
        abs(getattr(effect, name) - nothing) > AWAY * std.get((effect, name), 0.0)
        for name, nothing in effect.neutral.items()
        if getattr(effect, name) != nothing
    )


def named(model: FlexibleJointModel, effect: Effect, std: Mapping[tuple[Effect, str], float]) -> Suspect:
    """An effect with its numbers and their units."""
    joint = getattr(effect, "joint", None)
    prismatic = joint is not None and model.robot.kinds[model.index(joint)] == "prismatic"
    numbers = {}
    for entry in effect.parameters():
        unit = unit_for(str(entry.metadata["unit"]), prismatic=prismatic)
        numbers[entry.name] = Number(float(getattr(effect, entry.name)), std.get((effect, entry.name), 0.0), unit)
    return Suspect(effect.name, joint, getattr(effect, "side", None), numbers, _place(effect))


def out_of_tolerance(last: Refined) -> list[FileNumber]:
    """Numbers that were held by their tolerance and are surely out of it all the same."""
    std, held = last.factor_std(), set(last.hypothesis.factors) - last.hypothesis.freed
    return [
        number
        for number, factor in last.hypothesis.factors.items()
        if number in held and abs(factor - 1.0) - 2.0 * std[number] > IN_TOLERANCE * number.tolerance
    ]


def wrong_number(model: FlexibleJointModel, number: FileNumber, last: Refined) -> Suspect | None:
    """A number of the file that is off by more than its tolerance allows; None where it is not after all."""
    factor, std = last.hypothesis.factors[number], last.factor_std()[number]
    if abs(factor - 1.0) - 2.0 * std <= IN_TOLERANCE * number.tolerance:
        return None
    place = {"of": number.of, "parameter": number.parameter}
    return Suspect("parameter_error", number.joint, side_of(model, number), {"factor": Number(factor, std, "1")}, place)


def side_of(model: FlexibleJointModel, number: FileNumber) -> str | None:
    """Where a number acts: a joint's by its kind, an effect's own side."""
    place = effect_place(number.of)
    return SIDES.get(number.parameter) if place is None else getattr(model.effects[place], "side", None)


def calibrations(model: FlexibleJointModel, last: Refined) -> tuple[Calibration, ...]:
    """Numbers of the file that moved within their tolerance."""
    std = last.factor_std()
    return tuple(
        Calibration(number.of, number.parameter, float(factor), std[number], number.tolerance)
        for number, factor in last.hypothesis.factors.items()
        if number not in last.hypothesis.freed or abs(factor - 1.0) <= IN_TOLERANCE * number.tolerance
    )


def tried(model: FlexibleJointModel, among: Sequence[Alternative], chosen: Suspect) -> tuple[Tried, ...]:
    """The names among which one was chosen, as they compare with it."""
    found = [Tried(suspected(model, each), float(each.behind), float(each.gap)) for each in among]
    own = next((each.behind for each in found if each.suspect == dataclasses.replace(chosen, parameters={})), 0.0)
    return tuple(dataclasses.replace(each, behind=each.behind - own) for each in found)


def suspected(model: FlexibleJointModel, candidate: Candidate | Alternative) -> Suspect:
    """A candidate where it acts, without numbers."""
    if candidate.number is not None:
        number = candidate.number
        place = {"of": number.of, "parameter": number.parameter}
        return Suspect("parameter_error", number.joint, side_of(model, number), {}, place)
    effect = candidate.effect
    name = effect.name if effect is not None else ""
    return Suspect(name, getattr(effect, "joint", None), getattr(effect, "side", None), {}, _place(effect))


def _place(effect: Effect | None) -> dict[str, str]:
    return {key: str(getattr(effect, key)) for key in PLACES if getattr(effect, key, None) is not None}


def _experiment(suspect: Suspect, others: Sequence[Suspect]) -> str:
    """What would be seen differently; the regimes in which laws part."""
    names = " or ".join(dict.fromkeys(each.effect.replace("_", " ") for each in (suspect, *others)))
    joint = suspect.joint or "the arm"
    return (
        f"to tell {names} apart, move {joint} slowly through its range at several constant speeds in both directions, "
        "stop and reverse often, and repeat it with another load"
    )
