"""Absolute tolerances that stand beside numbers of motors, links and effects, as the relative ones of the model.

An unknown number is a placeholder, or what the URDF says, and has an infinite tolerance.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Mapping, Sequence
from typing import Any

from flexdyn.effects import Effect, registered
from flexdyn.errors import InputError, retold
from flexdyn.model.given_number import UNKNOWN, GivenNumber, given_number
from flexdyn.model.resolved_parameters import OF_MOTOR
from flexdyn.robot import Robot

SAME_MASS = 1e-6
"""Relative difference up to which a mass is that of the URDF [1]."""
EFFECT_PATH = re.compile(r"effects\[(\d+)\](\..*)")
"""Path of a parameter of an effect, by the effect's place in the list."""
WRITE_NUMBER = "write the number alone"
NOBODY_GIVES = 1e-150
"""What stands for an unknown number that must be above 0."""
Paths = dict[str, float]


def with_stated_tolerances(
    tolerance: Any, joints: Any, links: Any, effects: Sequence[Any], robot: Robot
) -> tuple[Any, Any, Any, list[Any]]:
    """Entries of a model with numbers in place of ``{value: .., tolerance: ..}``, and the tolerances with these added.

    Rotor inertia, stiffness, damping and inertias of links keep their own absolute tolerance. Entries of another form
    are handed on; whoever reads them refuses them.

    Args:
        tolerance: of the model: one relative number, or several by path.
        joints: entries by joint.
        links: entries by link.
        effects: effects and entries of them.
        robot: of the model.

    Returns:
        Tolerances, joints, links, effects.

    Raises:
        InputError: an unknown number for which no first value can be found, or a tolerance that no diagnosis can use.
    """
    stated: Paths = {}
    joints = _each(joints, lambda name, entry: _joint(joints, name, entry, stated, robot.joint_names))
    links = _each(links, lambda link, entry: _link(link, entry, stated, robot))
    if isinstance(links, Mapping):
        links = {link: entry for link, entry in links.items() if entry is not None}
    listed = [_effect(i, entry, stated) for i, entry in enumerate(effects)]
    if stated:
        tolerance = {**(tolerance if isinstance(tolerance, Mapping) else {"*": tolerance}), **stated}
    return tolerance, joints, links, listed


def _each(entries: Any, change: Callable[[str, Any], Any]) -> Any:
    """Every entry of a mapping that is a mapping itself, changed."""
    if not isinstance(entries, Mapping):
        return entries
    return {key: change(key, each) if isinstance(each, Mapping) else each for key, each in entries.items()}


def _joint(joints: Any, name: str, entry: Mapping[str, Any], stated: Paths, names: Sequence[str]) -> Any:
    """A joint's entry with the numbers of its motor alone; those of ``"*"`` are of every joint without an actuator."""
    actuator = entry.get("actuator")
    if not isinstance(actuator, Mapping) or not isinstance(actuator.get("dc_motor"), Mapping):
        return entry
    place, found = "actuator.dc_motor", dict(actuator["dc_motor"])
    for key, given in actuator["dc_motor"].items():
        path = f"joints.{name}.{place}.{key}"
        nobody = isinstance(given, str) and given == UNKNOWN and key in OF_MOTOR
        if number := GivenNumber(NOBODY_GIVES, math.inf) if nobody else _number(given, path, WRITE_NUMBER):
            if key not in OF_MOTOR:
                raise InputError("no diagnosis estimates this number", key=path, remedy=WRITE_NUMBER)
            found[key] = number.value
            bare = [each for each in names if each not in joints or "actuator" not in _keys(joints[each])]
            for each in bare if name == "*" else [name]:
                share = math.inf if number.is_unknown else _checked_share(number, path)
                stated[f"joints.{each}.{place}.{key}"] = share
    return {**entry, "actuator": {**actuator, "dc_motor": found}}


def _keys(entry: Any) -> Any:
    """Keys of a joint's entry; a `Joint` has all of them."""
    return entry if isinstance(entry, Mapping) else ("actuator",)


def _link(link: str, entry: Mapping[str, Any], stated: Paths, robot: Robot) -> Any:
    """A link's entry without the tolerance of its mass, which is in the URDF; None if nothing else is in it."""
    if "mass" not in entry:
        return entry
    key, given = f"links.{link}.mass", entry["mass"]
    with retold(key=f"links.{link}", value=None):
        mass = robot.link_size(link)[0]
    if isinstance(given, str) and given == UNKNOWN:
        stated[key] = math.inf
        return {name: value for name, value in entry.items() if name != "mass"} or None
    remedy = f"change it there, and write {{tolerance: 0.1}} or {UNKNOWN} here"
    number = _number({"value": mass, **given} if isinstance(given, Mapping) else given, key, remedy)
    if number is None or abs(number.value - mass) > SAME_MASS * mass:
        raise InputError(f"the URDF gives it as {mass:g} kg", key=key, value=given, remedy=remedy)
    stated[key] = _checked_share(number, key)
    return {name: value for name, value in entry.items() if name != "mass"} or None


def _effect(i: int, entry: Any, stated: Paths) -> Any:
    """An effect's entry with its numbers alone."""
    kind = registered().get(str(entry.get("effect"))) if isinstance(entry, Mapping) else None
    if kind is None:
        return entry
    found = dict(entry)
    for name in (field.name for field in kind.parameters() if field.name in entry):
        key = f"effects[{i}].{name}"
        if isinstance(entry[name], str) and entry[name] == UNKNOWN and name in kind.unknowable():
            found[name], stated[key] = placeholder(kind, name), math.inf
        elif number := _number(entry[name], key, "leave the effect out: a diagnosis finds it, with its numbers"):
            _check_estimated(kind, name, key)
            found[name], stated[key] = number.value, _checked_share(number, key)
    return found


def placeholder(kind: type[Effect], name: str) -> float:
    """What an effect holds for an unknown number, in its unit.

    Args:
        kind: class of the effect.
        name: of the parameter.
    """
    return NOBODY_GIVES if kind.declared(name)["strict"] else 0.0


def unknown_parameters(tolerance: Any, effects: Sequence[Effect]) -> list[tuple[int, str]]:
    """Effects by their place in the list, each with the name of a parameter that is unknown.

    Args:
        tolerance: of the model.
        effects: of the model, which hold a `placeholder` for an unknown number.
    """
    if not isinstance(tolerance, Mapping):
        return []
    return [
        (i, name)
        for i, effect in enumerate(effects)
        for name in effect.unknowable()
        if tolerance.get(f"effects[{i}].{name}") == math.inf
        and getattr(effect, name) == placeholder(type(effect), name)
    ]


def unknown_of_motors(tolerance: Any, joints: Mapping[str, Any]) -> list[tuple[str, str]]:
    """Joints, each with the name of a number of its motor that is unknown.

    Args:
        tolerance: of the model.
        joints: its drives by name, which hold a placeholder for an unknown number.
    """
    if not isinstance(tolerance, Mapping):
        return []
    motors = ((name, joint.actuator.dc_motor) for name, joint in joints.items() if joint.actuator is not None)
    return [
        (name, key)
        for name, motor in motors
        for key in OF_MOTOR
        if tolerance.get(f"joints.{name}.actuator.dc_motor.{key}") == math.inf and getattr(motor, key) == NOBODY_GIVES
    ]


def unknown_masses(tolerance: Any, links: Sequence[str]) -> list[str]:
    """The links whose mass is unknown.

    Args:
        tolerance: of the model.
        links: names of the robot's links.
    """
    return [
        each for each in links if isinstance(tolerance, Mapping) and tolerance.get(f"links.{each}.mass") == math.inf
    ]


def kept_tolerances(tolerance: Any, kept: Sequence[int]) -> Any:
    """The tolerances of a model of whose effects some are left out: ``effects[i]`` counts the others.

    Args:
        tolerance: of the model.
        kept: places of the effects that stay, in their order.
    """
    if not isinstance(tolerance, Mapping):
        return tolerance
    places, found = {old: new for new, old in enumerate(kept)}, {}
    for path, share in tolerance.items():
        of_effect = EFFECT_PATH.fullmatch(path)
        if of_effect is None:
            found[path] = share
        elif int(of_effect[1]) in places:
            found[f"effects[{places[int(of_effect[1])]}]{of_effect[2]}"] = share
    return found


def known_tolerances(tolerance: Any) -> Any:
    """The tolerances of a model without those that say that a number is unknown."""
    if not isinstance(tolerance, Mapping):
        return tolerance
    return {path: share for path, share in tolerance.items() if share != math.inf}


def _check_estimated(kind: type[Effect], name: str, key: str) -> None:
    if name not in kind.uncertain():
        raise InputError("no diagnosis estimates this number", key=key, remedy=WRITE_NUMBER)


def _number(entry: Any, key: str, remedy: str) -> GivenNumber | None:
    """A number with its absolute tolerance; None for an entry of another form; an unknown one is refused."""
    if not (isinstance(entry, Mapping) or (isinstance(entry, str) and entry == UNKNOWN)):
        return None
    number = given_number(entry, key)
    if number.is_unknown:
        raise InputError("this number cannot be unknown", key=key, value=entry, remedy=remedy)
    return number


def _checked_share(number: GivenNumber, key: str) -> float:
    """Tolerance as a share of the value."""
    if number.tolerance is None or number.value == 0.0 or math.isinf(number.value):
        remedy = "give a value other than 0, or leave the effect out"
        raise InputError("a tolerance here is a share of the value", key=key, value=number.value, remedy=remedy)
    return number.tolerance / abs(number.value)
