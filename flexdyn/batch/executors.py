"""Native threads of this process do the chunks of a study; `Dask` has the same methods."""

from __future__ import annotations

import os
from collections.abc import Iterable, Iterator
from concurrent.futures import FIRST_COMPLETED, ThreadPoolExecutor, wait
from itertools import islice
from threading import Event
from typing import Self

from flexdyn.batch.chunk import Done, Task
from flexdyn.checks import whole
from flexdyn.errors import InputError


class Threads:
    """Threads of this process: each does whole chunks, and the core runs without the interpreter's lock.

    One chunk is prepared and measured while others are integrated.

    Args:
        workers: default: the processors this process may use.

    Raises:
        InputError: not a number of workers.
    """

    def __init__(self, workers: int | None = None) -> None:
        count = len(os.sched_getaffinity(0)) if workers is None else workers
        self._count = whole("workers", count, 1, problem="a number of at least 1 is needed")
        self._stop = Event()
        self._pool: ThreadPoolExecutor | None = None

    def __enter__(self) -> Self:
        """Start without a chunk in progress."""
        self._stop.clear()
        self._pool = ThreadPoolExecutor(self._count, thread_name_prefix="flexdyn")
        return self

    def __exit__(self, *error: object) -> None:
        """Stop the chunks in progress: chunks that are not written are left for the next time."""
        self._stop.set()
        if self._pool is not None:
            self._pool.shutdown(cancel_futures=True)
            self._pool = None

    def run(self, task: Task, chunks: Iterable[int]) -> Iterator[Done]:
        """Do chunks, and yield each when it is written.

        Args:
            task: called with the number of a chunk.
            chunks: their numbers; the next one is started when a thread is free.

        Raises:
            InputError: the store cannot be written to, or this is outside of the context.
        """
        pool, waiting = self._pool, iter(chunks)
        if pool is None:
            raise InputError("the threads are not started", key="workers", remedy="use it in a with statement")
        working = {pool.submit(task, chunk, self._stop.is_set) for chunk in islice(waiting, 2 * self._count)}
        while working:
            done, working = wait(working, return_when=FIRST_COMPLETED)
            for future in done:
                working |= {pool.submit(task, chunk, self._stop.is_set) for chunk in islice(waiting, 1)}
                yield future.result()
