"""How loaded the machine is: bounds of time are held as they are on a free one, and wider beside other work."""

from __future__ import annotations

import time

SPENT = 0.1
"""Processor time of one look [s]."""


def slowed() -> float:
    """Time over processor time of a short piece of work: 1 on a free machine, 4 where four want the processor."""
    began, spent = time.monotonic(), time.thread_time()
    while time.thread_time() - spent < SPENT:
        pass
    return max(1.0, (time.monotonic() - began) / SPENT)
