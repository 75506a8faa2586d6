"""A million runs on a hundred machines, on paper: what one machine measured, multiplied out."""

from __future__ import annotations

import time
from collections.abc import Mapping
from typing import Any

RUNS = 1_000_000
MACHINES = 100
TASKS = 2_000


def constants(largest: Mapping[str, Any], study: Mapping[str, Any]) -> dict[str, float]:
    """What the plan is made of.

    Args:
        largest: the study of most runs, as measured.
        study: overhead and integration of a run.
    """
    runs = largest["runs"]
    return {
        "run_processor_seconds": largest["processor_seconds"] / runs,
        "integration_seconds": 1e-6 * study["integration_microseconds"],
        "worker_start_seconds": largest["start_seconds"],
        "scheduler_seconds_per_task": scheduler_seconds(),
        "store_bytes_per_run": 1e6 * largest["store_megabytes"] / runs,
        "files_per_chunk": largest["store_files"] / largest["chunks"],
        "chunk_runs": float(-(-runs // largest["chunks"])),
        "speed_up_of_two_threads": study["of_one_thread"],
    }


def scheduler_seconds() -> float:
    """What a task costs Dask's scheduler, worker and client beside the task itself [s]; all on this machine."""
    from distributed import Client

    with Client(processes=False, n_workers=1, threads_per_worker=1, dashboard_address=None) as client:
        client.gather(client.map(_nothing, range(TASKS)))
        begin = time.perf_counter()
        client.gather(client.map(_nothing, range(TASKS, 2 * TASKS)))
        return (time.perf_counter() - begin) / TASKS


def plan(found: Mapping[str, float]) -> list[str]:
    """The plan, line by line.

    Args:
        found: from `constants`.
    """
    threads = 2 * MACHINES
    efficiency = 0.5 * found["speed_up_of_two_threads"]
    lines = [
        f"{RUNS:,} runs on {MACHINES} machines of two processors like this one:",
        f"  a worker starts in {found['worker_start_seconds']:.1f} s, all at once (a shared file system takes longer)",
    ]
    for what, seconds, chunk in (
        ("this arm", found["run_processor_seconds"], found["chunk_runs"]),
        ("this arm, larger chunks", found["run_processor_seconds"], 1_000.0),
        ("an arm whose run costs 1 s", 1.0 + found["run_processor_seconds"], found["chunk_runs"]),
    ):
        computing = RUNS * seconds / (threads * efficiency)
        tasks = RUNS / chunk
        scheduling = tasks * found["scheduler_seconds_per_task"]
        last = chunk * seconds  # all but one thread may wait for the last chunk
        total = found["worker_start_seconds"] + max(computing, scheduling) + last
        each = 1e3 * found["scheduler_seconds_per_task"]
        lines += [
            f"  {what}: {RUNS:,} x {1e6 * seconds:,.0f} us",
            f"    / ({threads} threads x {efficiency:.2f}) = {computing:,.1f} s;",
            f"    {tasks:,.0f} tasks of {chunk:,.0f} runs x {each:.2f} ms = {scheduling:,.1f} s at the scheduler;",
            f"    the last chunk {last:,.1f} s; in all {total:,.0f} s",
        ]
    size = RUNS * found["store_bytes_per_run"]
    chunks = RUNS / found["chunk_runs"]
    lines.append(
        f"  the store: {size / 1e9:.2f} GB in {chunks * found['files_per_chunk']:,.0f} files, written by the workers; "
        f"nothing but {chunks:,.0f} small tasks goes through the scheduler"
    )
    return lines


def _nothing(number: int) -> int:
    return number
