"""Inertias of links that a model file gives instead of those of the URDF."""

from __future__ import annotations

import math
from collections.abc import Mapping
from functools import lru_cache
from types import MappingProxyType
from typing import Any

from flexdyn.errors import InputError, did_you_mean
from flexdyn.model.given_number import GivenNumber, given_number
from flexdyn.robot import Robot

INERTIA = "inertia"
UNIT = "kg m^2"
Links = Mapping[str, GivenNumber]


def link_inertias(entries: Any, robot: Robot) -> Links:
    """Moments of inertia by link, the same about every axis through its centre of mass [kg m^2], read-only.

    Args:
        entries: link -> ``{"inertia": 0.01}``, a number, ``unknown`` or a value with an absolute tolerance.
        robot: whose links they are.

    Raises:
        InputError: an unknown link or key, a link that moves no mass, or a negative moment.
    """
    if not isinstance(entries, Mapping):
        remedy = "write {LINK: {inertia: 0.01}}"
        raise InputError("links are a mapping by name", key="links", value=entries, remedy=remedy)
    found = {}
    for link, entry in entries.items():
        key = f"links.{link}"
        if not isinstance(entry, Mapping) or INERTIA not in entry:
            raise InputError("a link's inertia is needed", key=key, value=entry, remedy="write {inertia: 0.01}")
        for name in entry:
            if name != INERTIA:
                remedy = f"{did_you_mean(str(name), (INERTIA,))}; mass and centre of mass stand in the URDF"
                raise InputError("a link has no such key", key=f"{key}.{name}", remedy=remedy)
        number = given_number(entry[INERTIA], f"{key}.{INERTIA}")
        if not 0.0 <= number.value < math.inf:
            problem = "it must be finite and at least 0"
            raise InputError(problem, key=f"{key}.{INERTIA}", value=number.value, remedy="give it in kg m^2")
        try:
            robot.with_link_inertia(str(link), number.value)
        except InputError as error:
            raise InputError(error.problem, key=key, remedy=error.remedy) from None
        found[str(link)] = number
    return MappingProxyType(found)


def links_entry(links: Links) -> dict[str, Any]:
    """As a model file writes them."""
    return {link: {INERTIA: number.entry()} for link, number in links.items()}


def unknown_links(links: Links) -> dict[str, Any]:
    """The unknown ones, as a model file writes them."""
    return links_entry({link: number for link, number in links.items() if number.is_unknown})


def robot_with_links(robot: Robot, links: Links) -> Robot:
    """The robot with the known inertias instead of its own; the same object for the same inertias."""
    known = tuple((link, number.value) for link, number in links.items() if not number.is_unknown)
    return _with_inertias(robot, known)


@lru_cache(maxsize=16)
def _with_inertias(robot: Robot, known: tuple[tuple[str, float], ...]) -> Robot:
    for link, moment in known:
        robot = robot.with_link_inertia(link, moment)
    return robot
