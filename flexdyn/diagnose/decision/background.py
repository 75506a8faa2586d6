"""Work in a second thread while this one shows the progress, so that Ctrl-C always works."""

from __future__ import annotations

import contextlib
import contextvars
import signal
import threading
import time
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from queue import Empty
from typing import TypeVar

from flexdyn.diagnose.progress import Course, following

Progress = Callable[[str, float], None]
Answer = TypeVar("Answer")
STOPPING_TIME = 0.5
"""Time to wait for the end of stopped work [s]; after it the known results are reported without it."""
STOPPING = "flexdyn: stopping; what is known by now follows"
GUESSED = 0.1
"""Share of the work from which the remaining time is estimated [1]."""


def in_background(work: Callable[[], Answer], course: Course, progress: Progress) -> Answer:
    """Do some work in another thread and show its progress in this one.

    The core computes for seconds at a time, and meanwhile Python handles no signal in the thread that called it.

    Args:
        work: that calls `tell` and `check` of `flexdyn.diagnose.progress`.
        course: of the work.
        progress: called in this thread with every stage and the share of all work that is done.

    Raises:
        KeyboardInterrupt: Ctrl-C; what is known is in the course. The work ends at its next check.
    """
    over = threading.Event()

    def inside() -> Answer:
        """The work, followed; whoever waits hears of its end."""
        try:
            with following(course):
                return work()
        finally:
            over.set()

    pool = ThreadPoolExecutor(1, thread_name_prefix="flexdyn-diagnosis")
    try:
        doing = pool.submit(contextvars.copy_context().run, inside)
        while not doing.done() or not course.told.empty():
            try:
                stage, share, shown = course.told.get(timeout=0.05)
            except Empty:
                continue
            progress(stage, share)
            shown.set()
    except BaseException:
        course.stop.set()
        with contextlib.suppress(KeyboardInterrupt):  # another Ctrl-C ends the wait
            over.wait(STOPPING_TIME)
        raise
    finally:
        pool.shutdown(wait=False)  # its thread ends with the work
    return doing.result()


@contextmanager
def display_of(progress: Progress | bool | None) -> Iterator[Progress]:
    """How progress is shown: by a function of the user, by a bar in a terminal or notebook, or not at all.

    Args:
        progress: the function; False: nothing, not even a line at Ctrl-C; None or True: the bar.
    """
    if progress is False:
        yield _unseen
        return
    from rich.console import Console

    console = Console(stderr=True, markup=False, highlight=False, emoji=False)
    if callable(progress) or not (console.is_terminal or console.is_jupyter):
        with _acknowledged(lambda text: console.print(text, soft_wrap=True)):
            yield progress if callable(progress) else _unseen
        return
    from rich.progress import BarColumn, SpinnerColumn, TaskProgressColumn, TextColumn, TimeElapsedColumn
    from rich.progress import Progress as Bars

    left = TextColumn("{task.fields[left]}")
    columns = (SpinnerColumn(), TextColumn("{task.description}"), BarColumn(12), TaskProgressColumn())
    with Bars(*columns, TimeElapsedColumn(), left, console=console, transient=True) as bars:
        task, began = bars.add_task("starting", total=1.0, left=""), time.monotonic()

        def show(stage: str, share: float) -> None:
            """Move the bar to a stage and its share of the whole."""
            bars.update(task, description=stage, completed=share, left=_remaining(share, time.monotonic() - began))

        with _acknowledged(bars.console.print):
            yield show


def _remaining(share: float, spent: float) -> str:
    """Estimate of the remaining time, if enough of the work is done for one."""
    return f"{max(1.0, spent * (1.0 - share) / share):.0f} s left" if share >= GUESSED and spent > 1.0 else ""


@contextmanager
def _acknowledged(say: Callable[[str], None]) -> Iterator[None]:
    """Print a line as soon as Ctrl-C is pressed, in the thread that receives signals.

    Only if Python's own handler is installed: another one was installed on purpose.
    """
    ours = threading.current_thread() is threading.main_thread()
    if not ours or signal.getsignal(signal.SIGINT) is not signal.default_int_handler:
        yield
        return

    def heard(number: int, frame: object) -> None:
        """Say that the signal was heard, and let it interrupt."""
        say(STOPPING)
        raise KeyboardInterrupt

    signal.signal(signal.SIGINT, heard)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, signal.default_int_handler)


def _unseen(stage: str, share: float) -> None:
    """Progress that is not shown."""
