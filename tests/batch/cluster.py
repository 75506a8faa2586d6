"""A real Dask cluster for tests: a scheduler and workers as processes of their own, on loopback only."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

PATIENCE = 60.0
"""How long a process may take to start [s]."""


@dataclass
class Cluster:
    """A scheduler and its workers.

    Attributes:
        folder: of logs, and importable on the workers.
        address: of the scheduler.
        scheduler: its process.
        workers: theirs.
    """

    folder: Path
    address: str
    scheduler: subprocess.Popen[bytes]
    workers: list[subprocess.Popen[bytes]] = field(default_factory=list)

    def add_worker(self, settings: Mapping[str, str] | None = None) -> None:
        """Start one of one thread."""
        self.workers.append(
            _start("worker", [self.address, "--nthreads", "1", "--no-nanny"], self.folder, settings or {})
        )

    def kill_worker(self, place: int) -> None:
        """End a worker as a power cut would."""
        self.workers[place].send_signal(signal.SIGKILL)

    def kill_scheduler(self) -> None:
        """End the scheduler as a power cut would."""
        self.scheduler.send_signal(signal.SIGKILL)


@contextmanager
def cluster(folder: Path, workers: int = 2) -> Iterator[Cluster]:
    """Start a cluster; all its processes are gone in the end.

    Args:
        folder: of logs; workers can import what lies in it.
        workers: of one thread each.
    """
    where = folder / "scheduler.json"
    scheduler = _start("scheduler", ["--port", "0", "--scheduler-file", str(where)], folder, {})
    made = Cluster(folder, "", scheduler)
    try:
        made.address = _address(where)
        for _ in range(workers):
            made.add_worker()
        yield made
    finally:
        for process in (*made.workers, scheduler):
            process.kill()
            process.wait()


def _address(where: Path) -> str:
    end = time.monotonic() + PATIENCE
    while time.monotonic() < end:
        try:
            found: Any = json.loads(where.read_text(encoding="utf-8"))
            return str(found["address"])
        except (FileNotFoundError, ValueError):
            time.sleep(0.05)
    raise TimeoutError("the scheduler does not start")


def _start(kind: str, arguments: list[str], folder: Path, settings: Mapping[str, str]) -> subprocess.Popen[bytes]:
    environment = os.environ | {"PYTHONPATH": str(folder)} | dict(settings)
    loopback = ["--host", "127.0.0.1", "--dashboard-address", "127.0.0.1:0"]
    words = [sys.executable, "-m", f"distributed.cli.dask_{kind}", *arguments, *loopback]
    with open(folder / f"{kind}.log", "ab") as log:
        return subprocess.Popen(words, stdout=log, stderr=log, env=environment, cwd=folder)
