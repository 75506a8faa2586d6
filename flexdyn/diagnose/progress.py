"""The progress of a diagnosis, reported from anywhere in the work, and the points where it can be stopped."""

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
    """One diagnosis in progress, shared by the working thread and the displaying thread.

    Attributes:
        told: stages and shares that wait to be displayed, each with an event that is set after the display.
        stop: set if the work should end.
        stage: present stage.
        share: estimated share of the finished work [1].
        known: results so far, by name; read only after the work has been stopped.
    """

    told: queue.SimpleQueue[tuple[str, float, threading.Event]] = field(default_factory=queue.SimpleQueue)
    stop: threading.Event = field(default_factory=threading.Event)
    stage: str = ""
    share: float = 0.0
    known: dict[str, Any] = field(default_factory=dict)

    def tell(self, stage: str, share: float) -> None:
        """Report the present stage and wait until it was displayed."""
        check()
        self.stage, self.share = stage, max(share, self.share)
        shown = threading.Event()
        self.told.put((stage, self.share, shown))
        while not shown.wait(0.05):
            check()


STAGES = (
    "reading the equations", "comparing structures", "simulating windows", "opening the test data",
    "designing experiments",
)  # fmt: skip
"""Of a diagnosis, in their order."""
_COURSE: ContextVar[Course | None] = ContextVar("flexdyn_course", default=None)


@contextmanager
def following(course: Course) -> Iterator[None]:
    """A context in which reports and checks belong to one diagnosis."""
    before = _COURSE.set(course)
    try:
        yield
    finally:
        _COURSE.reset(before)


def tell(stage: str, share: float) -> None:
    """Report the present stage, if there is a display.

    Args:
        stage: in a few words; one of `STAGES` gets its number.
        share: share of the diagnosis that is finished [1].

    Raises:
        KeyboardInterrupt: the work should end.
    """
    course = _COURSE.get()
    if course is not None:
        place = f" ({STAGES.index(stage) + 1} of {len(STAGES)})" if stage in STAGES else ""
        course.tell(f"{stage}{place}", share)


def know(**entries: Any) -> None:
    """Store the results so far, in case the work is stopped."""
    course = _COURSE.get()
    if course is not None:
        course.known.update(entries)


def check() -> None:
    """End the work if it was stopped.

    Raises:
        KeyboardInterrupt: the work should end.
    """
    course = _COURSE.get()
    if course is not None and course.stop.is_set():
        raise KeyboardInterrupt
