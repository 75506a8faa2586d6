"""What the process that starts the tests may have set, and tests must not feel; fixtures of several folders.

Tests of Ctrl-C need one: a shell has its background jobs, and all that they start, ignore it. And pytest-xdist tells
its workers how wide the terminal is, which is not where the output of a test goes.
"""

from __future__ import annotations

import os
import signal

from tests.browser import one_browser

__all__ = ["one_browser"]

if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
    signal.signal(signal.SIGINT, signal.default_int_handler)
os.environ.pop("COLUMNS", None)
