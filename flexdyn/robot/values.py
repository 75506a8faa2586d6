"""Numbers in XML attributes, and the error for a wrong one."""

from __future__ import annotations

import math
from typing import Any

from flexdyn.errors import InputError

LARGEST = 1e15
"""Largest length, mass or moment of a robot; squares of such numbers are finite."""


LONGEST_NAME = 200
"""Largest number of letters in a name; names of channels, with the signal in front, have up to 255."""


def unfit_name(name: str) -> str:
    """Why a joint, link or frame cannot have this name; empty if it can."""
    if not name.isprintable():
        return "the name holds characters that do not print"
    return f"the name is longer than {LONGEST_NAME} characters" if len(name) > LONGEST_NAME else ""


def fail(element: Any, key: str, problem: str, value: Any = None, remedy: str | None = None) -> InputError:
    """The error for an element, or for what was made of one, with its line.

    Args:
        element: the XML element where it was found.
        key: its path: ``joint 'elbow'/axis``.
        problem: the fault.
        value: the given value.
        remedy: what the user can do.

    Returns:
        An InputError to raise.
    """
    line = element.sourceline
    return InputError(f"{problem}{f' (line {line})' if line else ''}", key=key, value=value, remedy=remedy, line=line)


def numbers(
    element: Any, attribute: str, key: str, count: int, default: tuple[float, ...] | None, *, finite: bool = True
) -> tuple[float, ...]:
    """The numbers of an attribute, separated by blanks.

    Args:
        element: the XML element.
        attribute: the attribute's name.
        key: its path, for the error.
        count: required number of values.
        default: used if the attribute is missing; None makes it required.
        finite: whether infinity is refused too (NaN always is).

    Returns:
        That many floats.

    Raises:
        InputError: missing, not numbers, too many or too few, NaN, infinite or absurdly large.
    """
    text = element.get(attribute)
    if text is None:
        if default is None:
            raise fail(element, key, f"has no {attribute}", remedy=f'add {attribute}="..."')
        return default
    wanted = "a number" if count == 1 else f"{count} numbers separated by blanks"
    example = "0.5" if count == 1 else " ".join("0" * (count - 1)) + " 1"
    try:
        values = tuple(float(word) for word in text.split())
    except ValueError:
        values = ()
    if len(values) != count or "_" in text:
        raise fail(element, key, f"not {wanted}", text, f'write it like "{example}"')
    if any(math.isnan(value) for value in values):
        raise fail(element, key, "not a number (NaN)", text, f"give {wanted}")
    if finite and any(abs(value) > LARGEST for value in values):
        raise fail(element, key, "not a finite number of a sensible size", text, "check the value and its unit")
    return values


def attribute_number(
    element: Any, attribute: str, key: str, default: float | None = None, *, finite: bool = True
) -> float:
    """The single number of an attribute; arguments and errors as in numbers()."""
    return numbers(element, attribute, key, 1, None if default is None else (default,), finite=finite)[0]


def name_of(element: Any, what: str) -> str:
    """The name of a link or joint element; InputError if it is missing, blank, or not usable for a channel."""
    name = str(element.get("name") or "").strip()
    if not name:
        raise fail(element, what, "has no name", remedy=f"write <{what} name=...>")
    if problem := unfit_name(name):
        raise fail(element, what, problem, name, "give it a short plain name")
    return name


def pose_of(element: Any, key: str) -> tuple[tuple[float, ...], tuple[float, ...]]:
    """Position [m] and roll, pitch, yaw [rad] of the ``<origin>`` in an element, zero where it is left out."""
    zero = (0.0, 0.0, 0.0)
    origin = element.find("origin")
    if origin is None:
        return zero, zero
    return numbers(origin, "xyz", f"{key}/origin/xyz", 3, zero), numbers(origin, "rpy", f"{key}/origin/rpy", 3, zero)
