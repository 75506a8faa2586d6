"""Names from a file as lines of text show them: they may be long, many, or made to fill a terminal."""

from __future__ import annotations

from collections.abc import Iterable

from flexdyn.errors import InputError, did_you_mean

LONGEST_ROS_NAME = 300
"""Characters of the longest name of a topic, type or column."""

_SHOWN = 60
_LISTED = 8


def check_word(name: str, what: str) -> None:
    """Refuse a name that does not print or is far too long.

    Raises:
        InputError: it is one.
    """
    if not name.isprintable() or len(name) > LONGEST_ROS_NAME:
        problem = f"the name of a {what} does not print, or is longer than {LONGEST_ROS_NAME} characters"
        raise InputError(problem, value=name[:_SHOWN], remedy="the file is damaged")


def listed(names: Iterable[str]) -> str:
    """The first of some names, each cut to a length that fits into a line."""
    every = list(names)
    return ", ".join(name[:_SHOWN] for name in every[:_LISTED]) + (", ..." if len(every) > _LISTED else "")


def near(word: str, known: Iterable[str]) -> str:
    """The near miss, if there is one, else the first of what there is."""
    every = list(known)
    found = did_you_mean(word, every)
    return found if found.startswith("did") else f"known: {listed(every)}"
