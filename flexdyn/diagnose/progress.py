"""How far a diagnosis is, said from wherever the work is done, and where it may be stopped."""

from __future__ import annotations

import queue
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass, field
from typing import Any


@dataclass(eq=False)
class Course:
    """One diagnosis under way, shared by the thread that works and the one that shows.

    Attributes:
        told: stages and shares that wait to be shown, each with an event that is set once it was.
        stop: set where the work is to end.
        stage: what is in work.
        share: of all work that is done, as far as that can be said [1].
        known: what is known by now, by a name; read only when the work has been stopped.
    """

    told: queue.SimpleQueue[tuple[str, float, threading.Event]] = field(default_factory=queue.SimpleQueue)
    stop: threading.Event = field(default_factory=threading.Event)
    stage: str = ""
    share: float = 0.0
    known: dict[str, Any] = field(default_factory=dict)

    def tell(self, stage: str, share: float) -> None:
        """Say what is in work and wait until that was shown."""
        check()
        self.stage, self.share = stage, max(share, self.share)
        shown = threading.Event()
        self.told.put((stage, self.share, shown))
        while not shown.wait(0.05):
            check()


_COURSE: ContextVar[Course | None] = ContextVar("flexdyn_course", default=None)


@contextmanager
def following(course: Course) -> Iterator[None]:
    """What is said and checked in here belongs to a course."""
    before = _COURSE.set(course)
    try:
        yield
    finally:
        _COURSE.reset(before)


def tell(stage: str, share: float) -> None:
    """Say what is in work, if anybody follows.

    Args:
        stage: in a few words.
        share: of all work of the diagnosis that is done [1].

    Raises:
        KeyboardInterrupt: the work is to end.
    """
    course = _COURSE.get()
    if course is not None:
        course.tell(stage, share)


def know(**entries: Any) -> None:
    """Keep what is known by now, for the case that the work is stopped."""
    course = _COURSE.get()
    if course is not None:
        course.known.update(entries)


def check() -> None:
    """Come to an end where that is wished.

    Raises:
        KeyboardInterrupt: the work is to end.
    """
    course = _COURSE.get()
    if course is not None and course.stop.is_set():
        raise KeyboardInterrupt
