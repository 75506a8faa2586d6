"""Why an effect was named or was not: candidates that ``--explain EFFECT@JOINT`` means, and what is told of them."""

from __future__ import annotations

import dataclasses
import math
from typing import Any

from flexdyn.checks import check_known
from flexdyn.diagnose.constants import ESTABLISHED
from flexdyn.diagnose.report.ranked import ranks
from flexdyn.diagnose.report.result import Diagnosis
from flexdyn.diagnose.report.sentences import filled_template
from flexdyn.diagnose.report.suspects import Suspect
from flexdyn.diagnose.report.words import is_number, names_number
from flexdyn.effects import SensorEffect, catalogue
from flexdyn.errors import InputError, did_you_mean
from flexdyn.model.flexible_joint_model import FlexibleJointModel

KEY = "explain"
SIDE_NAMES = ("link", "motor", "transmission", "sensor")


def explanation(diagnosis: Diagnosis, target: str) -> str:
    """The text, one paragraph for every candidate that the target means.

    Args:
        diagnosis: to be explained.
        target: see `Diagnosis.explain`.

    Raises:
        InputError: no such effect, or no such place.
    """
    found = [_facts(diagnosis, each) for each in resolved(diagnosis, target)]
    return filled_template("explain", diagnosis, target=target, found=found, ESTABLISHED=ESTABLISHED)


def _facts(diagnosis: Diagnosis, suspect: Suspect) -> dict[str, Any]:
    """What is told of a candidate: its finding, its entry among those compared, the structures that hold it, rivals."""
    entry = next((each for each in diagnosis.considered if each.suspect.key == suspect.key), None)
    finding = next((each for each in diagnosis.findings if suspect.key in {name.key for name in each.names}), None)
    held = ranks(diagnosis.structures, [suspect])
    whose = (suspect.place.get("of"), suspect.place.get("parameter"))
    moved = (each for each in diagnosis.calibration if is_number(suspect) and (each.of, each.parameter) == whose)
    # As computed, else as the structures have it.
    known = (entry.probability if entry else math.nan, suspect.probability)
    marginal = held.probability if diagnosis.structures else math.nan
    return {
        "suspect": suspect,
        "entry": entry,
        "finding": finding,
        "held": held,
        "probability": next((each for each in known if math.isfinite(each)), marginal),
        "moved": next(moved, None),
        "others": [] if finding is None else [each for each in finding.names if each.key != suspect.key],
    }


def target_of(suspect: Suspect) -> str:
    """The name of a suspect: its effect, and after ``@`` where it acts, without the side."""
    place = suspect.place
    if "channel" in place:
        where = place["channel"]
    elif is_number(suspect):
        where = f"{place.get('of', suspect.joint)}.{place.get('parameter', 'number')}"
    else:
        where = suspect.joint or ""
    return f"{suspect.effect}@{where}" if where else suspect.effect


def known_suspects(diagnosis: Diagnosis) -> list[Suspect]:
    """Every candidate in a diagnosis, findings first, then the most probable."""
    mentioned = [each for finding in diagnosis.findings for each in finding.names]
    mentioned += [each.suspect for each in diagnosis.considered]
    mentioned += [each for structure in diagnosis.structures for each in structure.effects]
    found = {suspect.key: suspect for suspect in reversed(mentioned)}
    known = [found[key] for key in dict.fromkeys(each.key for each in mentioned)]
    numbers = {target_of(suspect) for suspect in known}
    for number in diagnosis.calibration:
        joint = number.of if number.of in diagnosis.model.joint_names else None
        moved = Suspect.of_number(number.of, number.parameter, joint)
        if target_of(moved) not in numbers:
            known.append(moved)
    return known


def resolved(diagnosis: Diagnosis, target: str) -> list[Suspect]:
    """Every candidate that a target means; none where effect and joint exist and were not compared.

    Raises:
        InputError: no such effect, or no such place.
    """
    known = known_suspects(diagnosis)
    found = [each for each in known if target in _answers_to(each)]
    if found:
        return found
    check_target(diagnosis.model, target)
    numbers = [target_of(each) for each in known if is_number(each)]
    if "@" in target and names_number(target.partition("@")[0]) and numbers:
        raise InputError("no such number was compared", key=KEY, value=target, remedy=did_you_mean(target, numbers))
    return []


def check_target(model: FlexibleJointModel, target: str) -> None:
    """Find a target fit before any work is done: its effect is in the catalogue, its joint in the model.

    Raises:
        InputError: it can mean nothing; the remedy names the near miss.
    """
    effect, at, where = target.partition("@")
    check_known(effect, catalogue(), "no such effect", key=KEY, value=effect)
    if not at or names_number(effect):
        return
    places = list(model.joint_names)
    if issubclass(catalogue()[effect], SensorEffect):
        where = where.removesuffix(".sensor").partition(".")[2]
    elif any(field.name == "frame" for field in dataclasses.fields(catalogue()[effect])):  # type: ignore[arg-type]
        places += model.robot.frame_names
    if where not in places and not any(
        where == f"{joint}.{side}" for joint in model.joint_names for side in SIDE_NAMES
    ):
        raise InputError("no such place", key=KEY, value=target, remedy=did_you_mean(where, places))


def _answers_to(suspect: Suspect) -> set[str]:
    """All that a suspect answers to: its effect alone, its target, its target with side, frame or other joint."""
    target = target_of(suspect)
    names = {suspect.effect, target}
    if suspect.side is not None and "@" in target:
        names.add(f"{target}.{suspect.side}")
    if "frame" in suspect.place:
        names.add(f"{suspect.effect}@{suspect.place['frame']}")
    if "other" in suspect.place:
        names.add(f"{target}.{suspect.place['other']}")
    return names
