"""Names from a file in messages: they may be long, many, or contain control characters."""

from __future__ import annotations

from collections.abc import Iterable

from flexdyn import errors
from flexdyn.errors import InputError, did_you_mean

LONGEST_ROS_NAME = 300
"""Largest number of characters in the name of a topic, type or column."""

_SHOWN = 60
_LISTED = 8


def check_word(name: str, what: str) -> None:
    """Refuse a name that cannot be printed or is far too long.

    Raises:
        InputError: the name is refused.
    """
    if not name.isprintable() or len(name) > LONGEST_ROS_NAME:
        problem = f"the name of a {what} does not print, or is longer than {LONGEST_ROS_NAME} characters"
        raise InputError(problem, value=name[:_SHOWN], remedy="the file is damaged")


def shortened_list(names: Iterable[str]) -> str:
    """The first of some names, each cut to a length that fits into a line."""
    return errors.listed((name[:_SHOWN] for name in names), _LISTED)


def nearest_name(word: str, known: Iterable[str]) -> str:
    """The most similar name, if there is one, else the first of the existing names.

    Args:
        word: that is not known.
        known: all names.
    """
    every = list(known)
    found = did_you_mean(word, every)
    return found if found.startswith("did") else f"known: {shortened_list(every)}"
