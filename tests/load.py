"""How loaded the machine is: bounds of time are held as they are on a free one, and wider beside other work; a load."""

from __future__ import annotations

import os
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager

SPENT = 0.1
"""Processor time of one look [s]."""
FREE = 1.3
"""A free machine takes no more than so many times the processor time [1]."""
MARGIN = 2.0
"""Load comes and goes: the time looked at is not the time that counts [1]."""


def slowed() -> float:
    """How many times longer work may take now: 1 on a free machine, 8 where four want the processor."""
    began, spent = time.monotonic(), time.thread_time()
    while time.thread_time() - spent < SPENT:
        pass
    ratio = (time.monotonic() - began) / SPENT
    return 1.0 if ratio < FREE else MARGIN * ratio


@contextmanager
def busy_machine() -> Iterator[None]:
    """Twice as many processes as there are processors, each of which computes all the time."""
    words = [sys.executable, "-S", "-c", "while True: pass"]
    others = [subprocess.Popen(words) for _ in range(2 * len(os.sched_getaffinity(0)))]
    try:
        yield
    finally:
        for other in others:
            other.kill()
            other.wait()
