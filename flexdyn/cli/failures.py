"""Every error as one line on stderr and an exit code."""

from __future__ import annotations

import os
import sys
import traceback
from typing import Any

import typer

from flexdyn.errors import FlexdynError, did_you_mean, shown, visible

# Some versions of typer contain their own click, others use the real one: take the class that typer uses.
UsageError: type[Exception] = next(kind for kind in typer.BadParameter.__mro__ if kind.__name__ == "UsageError")


class ProgramInterrupted(Exception):
    """Ctrl-C, raised so that click does not print its own message."""


def print_error(error: BaseException) -> int:
    """Print an error on stderr.

    Args:
        error: that a command raised.

    Returns:
        The exit code: 2 for a wrong input, 130 for Ctrl-C, 1 for any other error.
    """
    debug = bool(os.environ.get("FLEXDYN_DEBUG"))
    if debug:
        traceback.print_exception(error)
    if isinstance(error, KeyboardInterrupt | ProgramInterrupted):
        return _say("interrupted", 130)
    if isinstance(error, FlexdynError):
        return _say(str(error), 2)
    if isinstance(error, UsageError):
        return _say(usage_line(error), 2)
    if isinstance(error, MemoryError):
        return _say("it does not fit into memory; use less, for example a lower --rate or a shorter --duration", 2)
    if isinstance(error, OSError) and error.strerror:
        return _say(f"{error.filename or 'output'}: {error.strerror}", 2)
    hint = "" if debug else "; run with FLEXDYN_DEBUG=1 for the traceback"
    return _say(f"internal error: {type(error).__name__}: {error}{hint}", 1)


def show_warning(message: Warning | str, *_: Any, **__: Any) -> None:
    """Print a warning as one line, without the source line that Python adds."""
    _say(f"warning: {message}", 0)


def usage_line(error: Any) -> str:
    """The error of a command's arguments, in one line with the most similar name.

    Args:
        error: click's UsageError.
    """
    context = getattr(error, "ctx", None)
    command = context.command_path if context else "flexdyn"
    where = "".join(f"{word}: " for word in command.split()[1:])
    if hasattr(error, "possibilities"):  # only an unknown option has them
        known = [name for entry in context.command.params for name in entry.opts] if context else []
        return f"{where}{shown(error.option_name)}: no such option; {did_you_mean(error.option_name, known)}"
    parameter = getattr(error, "param", None)
    message = str(error.message).rstrip(".")
    if parameter is not None and message:
        return f"{where}{_longest(parameter)}: {message}; see {command} --help"
    message = str(error.format_message()).rstrip(".")
    return f"{where}{message[:1].lower()}{message[1:]}; see {command} --help"


def _longest(parameter: Any) -> str:
    """An option as it is typed, an argument as the help calls it."""
    if getattr(parameter, "param_type_name", "") == "option":
        return str(max(parameter.opts, key=len))
    return str(parameter.metavar or parameter.name.upper())


def _say(text: str, code: int) -> int:
    print(f"flexdyn: {visible(' '.join(text.split()))}", file=sys.stderr, flush=True)  # noqa: T201
    return code
