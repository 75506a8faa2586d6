"""The program ``flexdyn``: Ctrl-C is answered by one line from its first moment to its last.

It stands beside the package: to import that takes a second, in which Python would answer by a traceback, and what
becomes of a signal is for a program to say, not for a library.
"""

from __future__ import annotations

import logging
import os
import re
import signal
import sys
from types import FrameType

INTERRUPTED = 130
"""128 + SIGINT: what a shell reports of a program that Ctrl-C ended."""


def main() -> int:
    """Run the command that the process was started with.

    Returns:
        The exit code.
    """
    asked = signal.getsignal(signal.SIGINT)
    ours = asked is signal.default_int_handler  # else whoever started us has said what is to become of it
    if ours:
        signal.signal(signal.SIGINT, _leave)
    try:
        from flexdyn.cli import main as run
    except ImportError as error:
        answer = _missing(error)
        if answer is None:
            raise
        sys.stderr.write(answer)
        return 2

    if ours:
        signal.signal(signal.SIGINT, asked)
    code = run()
    if ours:
        signal.signal(signal.SIGINT, signal.SIG_IGN)  # everything is done and said: libraries tidy up
    if code == INTERRUPTED:
        logging.disable()  # what they were at then, they would tell at length
    return code


def _missing(error: ImportError) -> str | None:
    """One line, if a library of the system is missing that a wheel counts on, as in small images of Linux."""
    found = re.match(r"(\S+\.so\S*): cannot open shared object file", str(error))
    if found is None:
        return None
    remedy = "install the package of your system that has it"
    if found[1].startswith("libgomp.so"):
        remedy = "Pinocchio needs it. Debian, Ubuntu: apt install libgomp1. Fedora: dnf install libgomp"
    return f"flexdyn: {found[1]}, a library of the system, is missing: {remedy}\n"


def _leave(number: int, frame: FrameType | None) -> None:
    """Nothing is begun yet."""
    os.write(2, b"flexdyn: interrupted\n")
    os._exit(INTERRUPTED)
