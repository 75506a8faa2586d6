"""Threads do every chunk once, keep no list of them, and stop when they are told to."""

from __future__ import annotations

import itertools
import threading
from collections.abc import Callable, Iterator
from typing import Any, cast

import pytest

from flexdyn.batch.chunk import Done, Stopped, Task
from flexdyn.batch.executors import Threads
from flexdyn.errors import InputError


def task(work: Callable[[int, Callable[[], bool]], Done]) -> Task:
    """Any callable in the place of a study's task."""
    return cast(Task, work)


def done(chunk: int, stopped: Any = None) -> Done:
    """A chunk of three runs, done at once."""
    return Done(chunk, 3, 0)


@pytest.mark.parametrize("workers", [1, 2, 5])
def test_every_chunk_is_done_once(workers: int) -> None:
    """Whatever the number of threads, and also where there is nothing to do."""
    with Threads(workers) as threads:
        assert sorted(each.chunk for each in threads.run(task(done), range(50))) == list(range(50))
        assert list(threads.run(task(done), [])) == []


def test_chunks_are_done_side_by_side() -> None:
    """Three threads meet at a barrier that none of them passes alone."""
    barrier = threading.Barrier(3, timeout=30)

    def meet(chunk: int, stopped: Callable[[], bool]) -> Done:
        barrier.wait()
        return done(chunk)

    with Threads(3) as threads:
        assert len(list(threads.run(task(meet), range(6)))) == 6


def test_chunks_are_taken_as_threads_become_free() -> None:
    """Of chunks without end only a few are asked for ahead of those that are done: no list of them is ever made."""
    asked: list[int] = []

    def endless() -> Iterator[int]:
        for chunk in itertools.count():
            asked.append(chunk)
            yield chunk

    with Threads(2) as threads:
        for seen, _ in enumerate(threads.run(task(done), endless()), 1):
            assert len(asked) <= seen + 4
            if seen == 1000:
                break
        assert seen == 1000


def test_an_error_ends_the_others() -> None:
    """What one chunk raises comes out, and chunks in work are told to stop instead of being waited for."""
    told = []

    def work(chunk: int, stopped: Callable[[], bool]) -> Done:
        if chunk == 1:
            raise InputError("cannot be written")
        while not stopped():
            threading.Event().wait(0.001)
        told.append(chunk)
        raise Stopped

    with pytest.raises(InputError, match="cannot be written"), Threads(2) as threads:
        list(threads.run(task(work), range(100)))
    assert told == [0]


def test_threads_can_be_started_again() -> None:
    """A second study is not stopped by the end of the first."""
    threads = Threads(1)
    for _ in range(2):
        with threads:
            assert len(list(threads.run(task(done), range(3)))) == 3
    with pytest.raises(InputError, match="not started"):
        list(threads.run(task(done), range(3)))
