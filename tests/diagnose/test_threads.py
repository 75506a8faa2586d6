"""The answer depends neither on the threads of the linear algebra, nor on those of the work, nor on the clock."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

import flexdyn as fd
from tests.arms import two_link
from tests.diagnose.truths import ARM, Levels, two_link_recording

SCRIPT = """
import json, os, sys, time
os.cpu_count = lambda: int(sys.argv[3])  # how many pieces of work are done at once
if sys.argv[3] != "1":  # a machine so loaded that all takes a thousand times as long, and threads that change often
    sys.setswitchinterval(1e-5)
    for name in ("time", "monotonic", "perf_counter", "process_time", "thread_time"):
        setattr(time, name, lambda clock=getattr(time, name): 1000.0 * clock())
import flexdyn as fd
answer = fd.diagnose(fd.load_model(sys.argv[1]), [fd.read_recording(sys.argv[2])]).to_dict()
print(json.dumps({key: value for key, value in answer.items() if key not in ("seconds", "record")}))
"""


def _answered(folder: Path, threads: int) -> str:
    """The report of a process of its own, which reads its number of threads when it starts."""
    environment = {**os.environ, "OPENBLAS_NUM_THREADS": str(threads), "OMP_NUM_THREADS": str(threads)}
    command = [sys.executable, "-c", SCRIPT, str(folder / "model.yaml"), str(folder / "fit.npz"), str(threads)]
    return subprocess.run(command, env=environment, check=True, capture_output=True, text=True).stdout


@pytest.mark.skipif(len(os.sched_getaffinity(0)) < 2, reason="one core has one thread")
def test_any_number_of_threads_tells_the_same(tmp_path: Path) -> None:
    """Every digit of the report but the time that it took and when that was; four threads of a slow machine."""
    wrong = two_link(ARM, tolerance=0.03).replace(joints={"elbow": {"stiffness": 1.4 * ARM.stiffness[1]}})
    fd.save_model(wrong, tmp_path / "model.yaml")
    fd.write_recording(two_link_recording(Levels(), 4), tmp_path / "fit.npz")
    one, four = (_answered(tmp_path, threads) for threads in (1, 4))
    assert json.loads(one)["findings"]
    assert four == one
