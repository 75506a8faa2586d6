"""simulate_many as a guest in Python: the lock is free, Ctrl-C stops it, progress is told, memory is given back."""

from __future__ import annotations

import os
import signal
import threading
from pathlib import Path

import pytest

import flexdyn as fd
from flexdyn.effects import Payload
from flexdyn.simulation.solvers import RungeKutta4
from tests.arms import BENT, two_link
from tests.lock import counted_beside
from tests.oracles.two_link import TwoLink

ARM = TwoLink(stiffness=(30.0, 20.0), damping=(0.1, 0.05))


def test_python_runs_beside_it() -> None:
    """A thread counts on while the runs are made: the interpreter's lock is free."""
    # A call that held the lock would leave some thousand at most.
    assert (
        counted_beside(
            lambda: fd.simulate_many([two_link(ARM)] * 4, None, 30.0, RungeKutta4(step=1e-4), rate=1, **BENT)
        )
        > 50_000
    )


@pytest.mark.parametrize("python_law", [False, True])
def test_ctrl_c_stops_it(python_law: bool) -> None:
    """KeyboardInterrupt arrives within runs that would last for days, and leaves flexdyn usable."""
    command = fd.Controller(lambda t, x: [0.0, 0.0]) if python_law else None
    timer = threading.Timer(0.3, os.kill, (os.getpid(), signal.SIGINT))
    timer.start()
    with pytest.raises(KeyboardInterrupt):
        fd.simulate_many([two_link(ARM)] * 3, command, 1e9, RungeKutta4(step=1e-4), rate=1e-6, **BENT)
    timer.join()
    (run,) = fd.simulate_many([two_link(ARM)], None, 0.1)
    assert isinstance(run, fd.Run)


def test_progress_counts_the_runs() -> None:
    """Runs that are done, never falling and never more than there are; an exception in it stops all."""
    seen: list[int] = []
    fd.simulate_many([two_link(ARM)] * 8, None, 20.0, RungeKutta4(step=1e-4), rate=1, progress=seen.append, **BENT)
    assert seen == sorted(seen)
    assert seen
    assert all(0 <= done <= 8 for done in seen)

    def stop(done: int) -> None:
        raise RuntimeError("enough")

    with pytest.raises(RuntimeError, match="enough"):
        fd.simulate_many([two_link(ARM)] * 3, None, 1e9, RungeKutta4(step=1e-4), rate=1e-6, progress=stop, **BENT)


def test_memory_is_given_back() -> None:
    """A hundred megabytes of results, thrown away round by round, leave the process as large as it was."""
    models = [two_link(ARM, [Payload(mass=0.1)])] * 4

    def grown() -> int:
        fd.simulate_many(models, None, 0.5, RungeKutta4(step=1e-3), rate=40_000.0, **BENT)
        pages = int(Path("/proc/self/statm").read_text(encoding="ascii").split()[1])
        return pages * os.sysconf("SC_PAGE_SIZE")

    first = [grown() for _ in range(3)][-1]
    last = [grown() for _ in range(12)][-1]
    assert last - first < 30e6  # each round makes 9 MB
