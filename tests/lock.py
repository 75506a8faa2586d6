"""How free the interpreter's lock is while the core computes."""

from __future__ import annotations

import threading
from collections.abc import Callable


def counted_beside(call: Callable[[], object]) -> int:
    """How far a thread counts while a call runs: millions where the lock is free, thousands where not."""
    started, done = threading.Event(), threading.Event()
    counts = {"during": 0}

    def count() -> None:
        started.set()
        while not done.is_set():
            counts["during"] += 1

    thread = threading.Thread(target=count)
    thread.start()
    started.wait()
    before = counts["during"]
    call()
    after = counts["during"]
    done.set()
    thread.join()
    return after - before
