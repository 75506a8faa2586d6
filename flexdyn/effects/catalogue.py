"""The catalogue: every effect by name, and an effect from a model file's entry."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from flexdyn.checks import check_known
from flexdyn.effects.base import Effect, registered
from flexdyn.errors import InputError

FILES = (
    "friction",
    "friction_of_load",
    "friction_of_state",
    "transmission",
    "actuator",
    "link",
    "coupling",
    "model_error",
    "sensor",
)
"""Modules of flexdyn's own effects, in the order of the catalogue."""


def catalogue() -> dict[str, type[Effect]]:
    """All effects by name: flexdyn's own in the order of the catalogue, then the users' own.

    Example:
        >>> list(fd.effects.catalogue())[:2]
        ['viscous_friction', 'coulomb_friction']
    """
    place = {f"flexdyn.effects.{file}": k for k, file in enumerate(FILES)}
    known = registered()
    return {name: known[name] for name in sorted(known, key=lambda name: place.get(known[name].__module__, len(FILES)))}


def names_where(holds: Callable[[type[Effect]], Any]) -> str:
    """Names of the effects whose class has a property, for a message: ``a``, ``a or b``, ``a, b or c``.

    Args:
        holds: whether a class has it.
    """
    names = [name for name, kind in catalogue().items() if holds(kind)]
    return " or ".join([", ".join(names[:-1]), *names[-1:]] if len(names) > 1 else names)


def find_effect(name: Any) -> type[Effect]:
    """The class of an effect with this name.

    Raises:
        InputError: there is no effect of that name; the message names the most similar one.
    """
    known = registered()
    check_known(name, known, "no such effect", key="effect", value=name)
    return known[name]


def effect_from_dict(entry: Any) -> Effect:
    """Make an effect from ``{effect: name, joint: ..., side: ..., parameters}``.

    Raises:
        InputError: an unknown effect, a parameter missing, unknown or out of bounds.

    Example:
        >>> fd.effects.effect_from_dict({"effect": "coulomb_friction", "joint": "elbow", "side": "motor", "level": 0.2})
        CoulombFriction(joint='elbow', side='motor', level=0.2)
    """
    if not isinstance(entry, Mapping):
        raise InputError("an effect is a mapping", value=entry, remedy="write {effect: NAME, joint: NAME, ...}")
    if "effect" not in entry:
        raise InputError("its name is missing", key="effect", remedy="write effect: NAME")
    rest = {str(key): value for key, value in entry.items() if key != "effect"}
    return find_effect(entry["effect"]).from_dict(rest)
