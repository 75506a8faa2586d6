"""Names of candidates for ``--explain``: ``coulomb_friction@elbow``, ``channel_lag@q.elbow``."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator

from flexdyn.diagnose.report.result import Diagnosis
from flexdyn.diagnose.report.suspects import Key, Suspect
from flexdyn.diagnose.report.words import is_number
from flexdyn.effects import SensorEffect, catalogue
from flexdyn.errors import InputError, did_you_mean
from flexdyn.model.flexible_joint_model import FlexibleJointModel

KEY = "explain"
SIDES = ("link", "motor", "transmission", "sensor")


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
    found: dict[Key, Suspect] = {}
    for suspect in _mentioned(diagnosis):
        found.setdefault(suspect.key, suspect)
    numbers = {target_of(suspect) for suspect in found.values()}
    for number in diagnosis.calibration:
        joint = number.of if number.of in diagnosis.model.joint_names else None
        moved = Suspect("parameter_error", joint, None, {}, {"of": number.of, "parameter": number.parameter})
        if target_of(moved) not in numbers:
            found.setdefault(moved.key, moved)
    return list(found.values())


def resolved(diagnosis: Diagnosis, target: str) -> list[Suspect]:
    """Every candidate that a target means; none where effect and joint exist and were not compared.

    Raises:
        InputError: no such effect, or no such place.
    """
    known = known_suspects(diagnosis)
    found = [each for each in known if target in _names(each)]
    if found:
        return found
    check_target(diagnosis.model, target)
    numbers = [target_of(each) for each in known if is_number(each)]
    if target.startswith("parameter_error@") and numbers:
        raise InputError("no such number was compared", key=KEY, value=target, remedy=did_you_mean(target, numbers))
    return []


def check_target(model: FlexibleJointModel, target: str) -> None:
    """Find a target fit before any work is done: its effect is in the catalogue, its joint in the model.

    Raises:
        InputError: it can mean nothing; the remedy names the near miss.
    """
    effect, at, where = target.partition("@")
    if effect not in catalogue():
        raise InputError("no such effect", key=KEY, value=effect, remedy=did_you_mean(effect, catalogue()))
    if not at or effect == "parameter_error":
        return
    places = list(model.joint_names)
    if issubclass(catalogue()[effect], SensorEffect):
        where = where.removesuffix(".sensor").partition(".")[2]
    elif any(field.name == "frame" for field in dataclasses.fields(catalogue()[effect])):  # type: ignore[arg-type]
        places += model.robot.frame_names
    if where not in places and not any(where == f"{joint}.{side}" for joint in model.joint_names for side in SIDES):
        raise InputError("no such place", key=KEY, value=target, remedy=did_you_mean(where, places))


def _mentioned(diagnosis: Diagnosis) -> Iterator[Suspect]:
    for finding in diagnosis.findings:
        yield from finding.names
    yield from (each.suspect for each in diagnosis.considered)
    for structure in diagnosis.structures:
        yield from structure.effects


def _names(suspect: Suspect) -> set[str]:
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
