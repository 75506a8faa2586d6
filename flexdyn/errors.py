"""The errors that flexdyn raises; each has its data and the remedy, and is printed as one line."""

from __future__ import annotations

import difflib
import re
import reprlib
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from functools import partial
from importlib.util import find_spec
from pathlib import Path
from typing import Any
from unicodedata import category

_LONGEST_ERROR_TEXT = 1_000_000
_LONGEST_ERROR_LINE = 1000
_LONGEST_WORD = 120
_LONGEST_ERROR = 1500
_LONG_WORD = re.compile(rf"\S{{{_LONGEST_WORD + 1},}}")


class FlexdynError(Exception):
    """Base of every error that flexdyn raises on purpose.

    Subclasses take keyword data, keep it as attributes, and can be pickled (a worker can send them back).

    Example:
        >>> try:
        ...     fd.load_model("nothing.yaml")
        ... except fd.FlexdynError as error:
        ...     print(type(error).__name__)
        InputError
    """

    def __init__(self, problem: str, **data: Any) -> None:
        self.problem = problem
        self.data = data
        super().__init__(problem)

    def __getattr__(self, name: str) -> Any:
        """Keyword data as attributes: error.file, error.key, error.t."""
        try:
            return self.__dict__["data"][name]
        except KeyError:
            raise AttributeError(name) from None

    def __reduce__(self) -> tuple[Any, ...]:
        """Pickle by problem and data: Exception would lose the keywords."""
        return (partial(type(self), **self.data), (self.problem,))

    def __str__(self) -> str:
        """One line of bounded length, for any name or message of a library in it."""
        return one_line(self.problem)


class InputError(FlexdynError, ValueError):
    """An input is wrong: a file, a key in it, a value, an option (exit code 2).

    Args:
        problem: the fault, in a few words.
        file: the file that has it, if any.
        key: the key, option or argument, dotted: ``joints.shoulder.stiffness``; default: the channel, if one is given.
        value: the given value.
        remedy: what the user can do.
        data: further data (row, channel, line).

    Example:
        >>> try:
        ...     fd.effects.ViscousFriction("elbow", side="motor", coefficient=-1.0)
        ... except fd.InputError as error:
        ...     print(error.key)
        viscous_friction.coefficient
    """

    def __init__(
        self,
        problem: str,
        *,
        file: str | Path | None = None,
        key: str | None = None,
        value: Any = None,
        remedy: str | None = None,
        **data: Any,
    ) -> None:
        key = data.get("channel") if key is None else key
        super().__init__(problem, file=file, key=key, value=value, remedy=remedy, **data)

    def __str__(self) -> str:
        """``file: key: problem, got value; remedy``."""
        where = "".join(f"{_clipped(str(part))}: " for part in (self.file, self.key) if part)
        got = "" if self.value is None else f", got {shown(self.value)}"
        remedy = f"; {one_line(str(self.remedy))}" if self.remedy else ""
        line = " ".join(f"{where}{one_line(self.problem)}{got}{remedy}".split())
        return line if len(line) <= _LONGEST_ERROR else f"{line[: _LONGEST_ERROR - 3]}..."

    def at(self, *, file: str | Path | None = None, key: str | None = None) -> InputError:
        """A copy of the error with the place of the fault, added by a caller that knows it."""
        data = dict(self.data)
        data["file"] = data["file"] or file
        data["key"] = ".".join(part for part in (key, data["key"]) if part) or ("" if "channel" in data else None)
        return type(self)(self.problem, **data)


class SimulationError(FlexdynError, RuntimeError):
    """An integration could not continue: not finite, step too small, too many steps.

    Data: ``t`` [s] where it stopped, ``state`` x there, ``solver``, ``reason``.

    Example:
        >>> issubclass(fd.SimulationError, fd.FlexdynError)
        True
    """


class MissingExtra(FlexdynError, ImportError):
    """An optional dependency is not installed; the message names the extra that installs it (exit code 2).

    Example:
        >>> issubclass(fd.MissingExtra, fd.FlexdynError)
        True
    """

    def __init__(self, library: str, extra: str) -> None:
        super().__init__(
            f"{library} is not installed; install it with: pip install 'flexdyn[{extra}]'", library=library, extra=extra
        )

    def __reduce__(self) -> tuple[Any, ...]:
        """Pickle by two plain strings."""
        return (type(self), (self.data["library"], self.data["extra"]))


@contextmanager
def needed(library: str, extra: str) -> Iterator[None]:
    """Around the imports of an optional library.

    Args:
        library: its name.
        extra: that brings it.

    Raises:
        MissingExtra: it is not installed.
    """
    try:
        yield
    except ImportError:
        raise MissingExtra(library, extra) from None


@contextmanager
def placed(*, file: str | Path | None = None, key: str | None = None) -> Iterator[None]:
    """Around code whose errors do not know where the fault is: they get this place, as by `InputError.at`."""
    try:
        yield
    except InputError as error:
        raise error.at(file=file, key=key) from error.__cause__


@contextmanager
def retold(**data: Any) -> Iterator[None]:
    """Around code whose errors name another place than the user's: these data replace those of the error."""
    try:
        yield
    except InputError as error:
        raise InputError(error.problem, **(error.data | data)) from None


def check_installed(library: str, extra: str) -> None:
    """Check that an optional library is installed, without loading it.

    Raises:
        MissingExtra: it is not installed.
    """
    if find_spec(library) is None:
        raise MissingExtra(library, extra)


def did_you_mean(word: str, known: Iterable[str]) -> str:
    """The remedy for an unknown word: the most similar known word if there is one, else all known words.

    Args:
        word: the given word.
        known: accepted words.

    Returns:
        ``did you mean 'stiffness'?`` or ``known: a, b, c``.
    """
    options = [str(option) for option in known]
    near = difflib.get_close_matches(str(word), options, n=1, cutoff=0.6)
    return f"did you mean '{near[0]}'?" if near else f"known: {listed(options, 40)}"


def listed(names: Iterable[str], most: int) -> str:
    """The first `most` names for a message, with dots if there are more."""
    every = list(names)
    return ", ".join(every[:most]) + (", ..." if len(every) > most else "")


def shown(value: Any) -> str:
    """A value for an error message, shortened, so that no input makes the line too long."""
    short = reprlib.Repr()
    short.maxstring = short.maxother = short.maxlong = 120
    short.maxlevel = 3
    try:
        return _clipped(short.repr(value))
    except ValueError:  # Python does not print integers of thousands of digits
        return f"something of type {type(value).__name__}"


def one_line(text: str) -> str:
    """A text as one line of up to 1000 characters without control characters.

    Control characters, and those that change the direction of writing, become spaces; a word of more than 120
    characters is shortened.

    Args:
        text: may contain names from a file.
    """
    plain = " ".join(printable(text[:_LONGEST_ERROR_TEXT]).split())
    plain = _LONG_WORD.sub(lambda word: f"{word[0][:60]}...{word[0][-57:]}", plain)
    return plain if len(plain) <= _LONGEST_ERROR_LINE else f"{plain[: _LONGEST_ERROR_LINE - 3]}..."


def visible(text: str, *, lines: bool = False) -> str:
    """A text of any length for a terminal: control characters are escaped as in Python; spaces of any width stay.

    Args:
        text: may contain names from a file.
        lines: whether to keep line breaks.
    """
    if text.isprintable():
        return text
    shown = (letter.isprintable() or category(letter) == "Zs" or (lines and letter == "\n") for letter in text)
    return "".join(letter if safe else repr(letter)[1:-1] for letter, safe in zip(text, shown, strict=True))


def _clipped(text: str) -> str:
    """A name, a path or a value as from `one_line`, with up to 240 characters; its spaces are kept."""
    plain = printable(text[:1000])
    return plain if len(plain) <= 240 else f"{plain[:237]}..."


def printable(text: str) -> str:
    """The text with a blank for every letter that does not print."""
    return text if text.isprintable() else "".join(letter if letter.isprintable() else " " for letter in text)
