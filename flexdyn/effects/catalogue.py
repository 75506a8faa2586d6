"""The catalogue: every effect by name, and an effect out of a model file's entry."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from flexdyn.effects.base import Effect, registered
from flexdyn.errors import InputError, did_you_mean


def catalogue() -> dict[str, type[Effect]]:
    """All effects by name: flexdyn's own in the order of their definition, then the users' own."""
    return dict(registered())


def find_effect(name: Any) -> type[Effect]:
    """The class of an effect's name.

    Raises:
        InputError: there is no effect of that name; the near miss is named.
    """
    known = registered()
    if not isinstance(name, str) or name not in known:
        raise InputError("no such effect", key="effect", value=name, remedy=did_you_mean(str(name), known))
    return known[name]


def effect_from_dict(entry: Any) -> Effect:
    """An effect out of ``{effect: name, joint: ..., side: ..., parameters}``.

    Raises:
        InputError: an unknown effect, a parameter missing, unknown or out of bounds.
    """
    if not isinstance(entry, Mapping):
        raise InputError("an effect is a mapping", value=entry, remedy="write {effect: NAME, joint: NAME, ...}")
    if "effect" not in entry:
        raise InputError("its name is missing", key="effect", remedy="write effect: NAME")
    rest = {str(key): value for key, value in entry.items() if key != "effect"}
    return find_effect(entry["effect"]).from_dict(rest)
