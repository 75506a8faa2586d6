"""Work in a second thread, while this one shows the progress, so that Ctrl-C is always answered."""

from __future__ import annotations

import contextvars
import threading
import time
from collections.abc import Callable
from queue import Empty
from typing import Generic, TypeVar

from flexdyn.diagnose.progress import Course, following

Progress = Callable[[str, float], None]
Answer = TypeVar("Answer")
STOPPING_TIME = 0.5
"""Time to wait for the end of stopped work [s]; after it the known results are reported without it."""


class _Work(threading.Thread, Generic[Answer]):
    """The work and what came of it."""

    def __init__(self, work: Callable[[], Answer], course: Course) -> None:
        super().__init__(name="flexdyn-diagnosis")
        self.answer: list[Answer] = []
        self.error: BaseException | None = None
        self._work, self._course = work, course
        self._around = contextvars.copy_context()

    def run(self) -> None:
        """Do it, in the context of the thread that asked."""
        self._around.run(self._inside)

    def _inside(self) -> None:
        with following(self._course):
            try:
                self.answer.append(self._work())
            except BaseException as error:
                self.error = error


def beside(work: Callable[[], Answer], course: Course, progress: Progress) -> Answer:
    """Do some work in another thread and show its progress in this one.

    The core computes for seconds at a time, and meanwhile Python handles no signal in the thread that called it.

    Args:
        work: that calls `tell` and `check` of `flexdyn.diagnose.progress`.
        course: of the work.
        progress: called in this thread with every stage and the share of all work that is done.

    Raises:
        KeyboardInterrupt: Ctrl-C; what is known is in the course. The work ends at its next check.
    """
    thread = _Work(work, course)
    try:
        thread.start()
        while thread.is_alive() or not course.told.empty():
            try:
                stage, share, shown = course.told.get(timeout=0.05)
            except Empty:
                continue
            progress(stage, share)
            shown.set()
        thread.join()
    except BaseException:
        course.stop.set()
        _wait(thread)
        raise
    if thread.error is not None:
        raise thread.error
    return thread.answer[0]


def _wait(thread: threading.Thread) -> None:
    """A moment for the work to come to its end; another Ctrl-C ends that."""
    end = time.monotonic() + STOPPING_TIME
    try:
        while thread.is_alive() and time.monotonic() < end:
            thread.join(0.02)
    except KeyboardInterrupt:
        return
