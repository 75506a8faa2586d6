"""Progress of a diagnosis: shown where it is asked for, and stopped from wherever the work is."""

from __future__ import annotations

import os
import pty
import subprocess
import sys
import threading
import time
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from typing import Any

import pytest

from flexdyn.diagnose.decision.background import in_background
from flexdyn.diagnose.parallel import in_parallel
from flexdyn.diagnose.progress import Course, check, know, tell


def test_work_is_done_beside_and_its_answer_comes_back() -> None:
    """In another thread; stages are shown in this one, in their order, before the work goes on."""
    here = threading.get_ident()
    told: list[tuple[str, float]] = []
    seen: list[list[tuple[str, float]]] = []

    def work() -> int:
        tell("one", 0.25)
        seen.append(list(told))
        tell("two", 0.75)
        tell("two again", 0.5)
        return threading.get_ident()

    def show(stage: str, share: float) -> None:
        assert threading.get_ident() == here
        told.append((stage, share))

    assert in_background(work, Course(), show) != here
    assert told == [("one", 0.25), ("two", 0.75), ("two again", 0.75)], "a share never falls"
    assert seen == [[("one", 0.25)]]


def test_an_error_of_the_work_is_raised_here() -> None:
    """As it is."""

    def work() -> None:
        raise ValueError("too short")

    with pytest.raises(ValueError, match="too short"):
        in_background(work, Course(), lambda stage, share: None)


def test_work_abreast_is_stopped_and_what_was_known_stays() -> None:
    """Threads of the work come to an end at their next check; nobody waits for all of it."""
    course, done = Course(), []

    def item(k: int) -> None:
        time.sleep(0.05)
        check()
        done.append(k)

    def work() -> None:
        know(first=1)
        tell("begun", 0.0)
        in_parallel(item, range(1000))

    def show(stage: str, share: float) -> None:
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        in_background(work, course, show)
    assert (course.known, course.stage) == ({"first": 1}, "begun")
    assert len(done) < 1000


def test_work_that_does_not_listen_is_not_waited_for() -> None:
    """What the core computes for seconds goes on, and the answer does not wait for it."""
    free, over = threading.Event(), threading.Event()

    def deaf() -> None:
        with suppress(KeyboardInterrupt):
            tell("begun", 0.0)
        free.wait(60.0)
        over.set()

    def show(stage: str, share: float) -> None:
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        in_background(deaf, Course(), show)
    assert not over.is_set(), "it was waited for"
    free.set()
    assert over.wait(60.0)


SHOWN = """
import sys, time
from flexdyn.diagnose.decision.background import display_of
with display_of({progress}) as show:
    show("comparing structures (2 of 5)", 0.4)
    time.sleep(1.6)
    show("simulating windows (3 of 5)", 0.5)
    time.sleep(0.4)
"""


@pytest.mark.parametrize("progress", ["None", "True"])
def test_a_terminal_shows_stage_share_and_time(progress: str) -> None:
    """The clock runs on while nothing is said, and what is left is guessed."""
    said = _in_a_terminal(SHOWN.format(progress=progress))
    for text in ("comparing structures (2 of 5)", "40%", "simulating windows (3 of 5)", "0:00:01", "s left"):
        assert text in said


def test_progress_can_be_silenced() -> None:
    """Not a letter."""
    assert _in_a_terminal(SHOWN.format(progress="False")) == ""


def _in_a_terminal(program: str) -> str:
    """What a program writes to stderr where that is a terminal of 80 columns."""
    ours, theirs = pty.openpty()
    env = {**os.environ, "TERM": "xterm", "COLUMNS": "80"}
    with subprocess.Popen([sys.executable, "-c", program], stderr=theirs, env=env) as running:
        os.close(theirs)
        said = b""
        while True:
            try:
                piece = os.read(ours, 4096)
            except OSError:  # the other end is closed
                break
            if not piece:
                break
            said += piece
        assert running.wait() == 0
    os.close(ours)
    return said.decode()


def test_work_is_stopped_wherever_the_interrupt_falls(monkeypatch: pytest.MonkeyPatch) -> None:
    """Also between the start of the work and the loop that shows it: else it would wait for ever to be shown."""
    submit = ThreadPoolExecutor.submit

    def interrupted(self: ThreadPoolExecutor, *args: Any) -> None:
        submit(self, *args)
        raise KeyboardInterrupt

    monkeypatch.setattr(ThreadPoolExecutor, "submit", interrupted)
    course = Course()
    with pytest.raises(KeyboardInterrupt):
        in_background(lambda: tell("at work", 0.5), course, lambda stage, share: None)
    assert course.stop.is_set()
    for thread in threading.enumerate():
        if thread.name.startswith("flexdyn-diagnosis"):
            thread.join(1.0)
            assert not thread.is_alive()
