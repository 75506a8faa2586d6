"""The command line: runs the command, and reports an error in one line.

Exit codes: 0 done; 2 an input is wrong; 1 a fault of flexdyn, or a failed check of the study; 130 interrupted.
"""

from __future__ import annotations

import os
import sys
import warnings
from collections.abc import Sequence

from flexdyn.cli import completion
from flexdyn.cli.failures import print_error, show_warning

INTERRUPTED = 130
"""128 + SIGINT: the exit code of a tool that Ctrl-C ended; typer returns it without a message."""
BROKEN_PIPE = 141
"""128 + SIGPIPE: the exit code of a tool whose output is no longer read."""


def main(argv: Sequence[str] | None = None) -> int:
    """Run one command.

    Args:
        argv: arguments without the program's name; default: those of the process.

    Returns:
        The exit code.
    """
    arguments = list(sys.argv[1:] if argv is None else argv) or ["--help"]
    with warnings.catch_warnings():
        warnings.showwarning = show_warning
        try:
            code = _run_command(arguments)
            sys.stdout.flush()
        except SystemExit as done:
            if completion.asked():  # click answers a shell and leaves
                return done.code if isinstance(done.code, int) else 0
            _mute()  # rich and click turn a broken pipe into SystemExit
            return BROKEN_PIPE
        except BrokenPipeError:
            _mute()
            return BROKEN_PIPE
        except (Exception, KeyboardInterrupt) as error:
            code = print_error(error)
            _drop_the_rest()
    return code


def _run_command(arguments: list[str]) -> int:
    """Run a command; its exit code."""
    from flexdyn.cli.app import build

    if sys.stdout is None or sys.stderr is None:  # closed by the caller: >&-
        nowhere = open(os.devnull, "w", encoding="utf-8")  # noqa: SIM115 - as long as the process
        sys.stdout, sys.stderr = sys.stdout or nowhere, sys.stderr or nowhere
    for stream in (sys.stdout, sys.stderr):
        if hasattr(stream, "reconfigure"):  # a name may have letters that it lacks
            stream.reconfigure(errors="backslashreplace")
    result = build().main(args=arguments, prog_name="flexdyn", standalone_mode=False)
    if result == INTERRUPTED:  # while the arguments were read
        raise KeyboardInterrupt
    return result if isinstance(result, int) else 0


def _drop_the_rest() -> None:
    """What a full disk did not take, Python 3.14 tries to write once more at its end, and would tell that at length."""
    try:
        sys.stdout.flush()
    except OSError:
        _mute()


def _mute() -> None:
    """The output is no longer read: discard the interpreter's last flush."""
    nowhere = os.open(os.devnull, os.O_WRONLY)
    os.dup2(nowhere, sys.stdout.fileno())
