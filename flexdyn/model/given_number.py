"""A number of a model file: a value, ``unknown``, or one with an absolute tolerance; inertias of links given so."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache
from types import MappingProxyType
from typing import Any

from flexdyn.checks import as_number, number
from flexdyn.errors import InputError, did_you_mean, retold
from flexdyn.io.yaml import check_keys
from flexdyn.robot import Robot

UNKNOWN = "unknown"
"""The word of a model file for an unknown number."""
GIVEN_KEYS = ("value", "tolerance")
WRITE_UNKNOWN = "write unknown for a number that nobody knows"


@dataclass(frozen=True)
class GivenNumber:
    """A number and how well it is known.

    Attributes:
        value: in its unit; 0 if it is unknown.
        tolerance: absolute, one standard deviation, in the same unit; infinite: the number is unknown; None: the
            relative tolerance of the model applies.
    """

    value: float
    tolerance: float | None = None

    @property
    def is_unknown(self) -> bool:
        """Whether the number is unknown."""
        return self.tolerance == math.inf

    def entry(self) -> Any:
        """As a model file writes it."""
        if self.tolerance is None:
            return self.value
        return UNKNOWN if self.is_unknown else {"value": self.value, "tolerance": self.tolerance}


def given_number(entry: Any, key: str) -> GivenNumber:
    """Read an entry of a model file.

    Args:
        entry: a number, ``unknown`` or ``{value: 0.0, tolerance: 0.02}``.
        key: its path in the file, for messages.

    Raises:
        InputError: it is none of these.
    """
    if isinstance(entry, str) and entry == UNKNOWN:
        return GivenNumber(0.0, math.inf)
    if not isinstance(entry, Mapping):
        found = as_number(entry)
        if math.isnan(found):
            raise InputError("a number is needed", key=key, value=entry, remedy=WRITE_UNKNOWN if entry is None else "")
        return GivenNumber(found)
    check_keys(entry, GIVEN_KEYS, key=key)
    for name in GIVEN_KEYS:
        if name not in entry:
            raise InputError("it is missing", key=f"{key}.{name}", remedy="write {value: 0.0, tolerance: 0.02}")
    value = number(f"{key}.value", entry["value"], remedy=f"{WRITE_UNKNOWN}, in place of the mapping")
    remedy = f"it is absolute, one standard deviation; {WRITE_UNKNOWN}"
    problem = "a number above 0 is needed"
    return GivenNumber(value, number(f"{key}.tolerance", entry["tolerance"], problem, above=0.0, remedy=remedy))


def refusal(key: str, unit: str) -> InputError:
    """The error of a simulation whose model has an unknown number.

    Args:
        key: path of the number in the file.
        unit: of the number.
    """
    remedy = f"write it in {unit}, or estimate it from a recording with flexdyn diagnose"
    return InputError("the number is unknown, and nothing can be computed without it", key=key, remedy=remedy)


INERTIA = "inertia"
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
        for name in entry if isinstance(entry, Mapping) else ():
            if name != INERTIA:
                remedy = (
                    f"{did_you_mean(str(name), (INERTIA, 'mass'))}; the centre of mass is in the URDF, and"
                    f" tolerance: {{links.{link}.com: 0.05}} says how well it is known"
                )
                raise InputError("a link has no such key", key=f"{key}.{name}", remedy=remedy)
        if not isinstance(entry, Mapping) or INERTIA not in entry:
            raise InputError("a link's inertia is needed", key=key, value=entry, remedy="write {inertia: 0.01}")
        number = given_number(entry[INERTIA], f"{key}.{INERTIA}")
        if not 0.0 <= number.value < math.inf:
            problem = "it must be finite and at least 0"
            raise InputError(problem, key=f"{key}.{INERTIA}", value=number.value, remedy="give it in kg m^2")
        with retold(key=key, value=None):
            robot.with_link_inertia(str(link), number.value)
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
