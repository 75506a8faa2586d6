"""Independent pieces of work in parallel on the machine's cores."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable
from concurrent.futures import ThreadPoolExecutor
from contextvars import Context, copy_context
from functools import partial
from typing import TypeVar

import numpy as np

from flexdyn.diagnose.progress import check

Item = TypeVar("Item")
Result = TypeVar("Result")
SILENT = partial(np.errstate, over="ignore", invalid="ignore")
"""Ignore overflow, which is detected afterwards in the results; every thread has its own setting."""


def in_parallel(work: Callable[[Item], Result], items: Iterable[Item]) -> list[Result]:
    """The results of `work` for all items, in their order.

    NumPy and the core let other threads run while they compute. The threads end with the call, so that a process that
    is forked later has none of them.

    Args:
        work: function whose result does not depend on other items.
        items: its arguments.
    """
    tasks = [(copy_context(), item) for item in items]

    def do(task: tuple[Context, Item]) -> Result:
        """One piece of work, in the context of who asked for it."""
        return task[0].run(_unless_stopped, work, task[1])

    with ThreadPoolExecutor(max(2, os.cpu_count() or 2), thread_name_prefix="flexdyn-parallel") as pool:
        return list(pool.map(do, tasks) if len(tasks) > 1 else map(do, tasks))


def _unless_stopped(work: Callable[[Item], Result], item: Item) -> Result:
    check()
    return work(item)
