"""What flexdyn adds to a process: time to import it, memory of a long run. Each is measured in fresh processes."""

from __future__ import annotations

import json
import statistics
import subprocess
import sys
from pathlib import Path

IMPORT = """
import json, time
start = time.perf_counter()
import numpy, pinocchio
between = time.perf_counter()
import flexdyn
print(json.dumps([between - start, time.perf_counter() - between]))
"""

# VmHWM and not ru_maxrss: on Linux the latter starts from the parent's peak, even across exec, and hides the run.
MEMORY = """
import json
import flexdyn as fd
from arms import with_laws

def peak():
    with open("/proc/self/status") as status:
        return next(int(line.split()[1]) * 1024 for line in status if line.startswith("VmHWM"))

model = with_laws("panda")
fd.simulate(model, duration=0.1, theta0="equilibrium")
before = peak()
run = fd.simulate(model, duration=60.0, rate=1000.0, theta0="equilibrium")
growth = peak() - before
held = sum(getattr(run, name).nbytes for name in ("t", "q", "theta", "v", "omega", "tau", "tau_applied", "tau_s"))
print(json.dumps([run.model.n, len(run.t), growth / 1e6, held / 1e6]))
"""


def import_seconds(times: int = 15) -> tuple[float, float]:
    """Medians over fresh processes.

    Returns:
        time to import numpy and pinocchio, and what flexdyn adds to it [s].
    """
    pairs = [_python(IMPORT) for _ in range(times)]
    return statistics.median(pair[0] for pair in pairs), statistics.median(pair[1] for pair in pairs)


def run_megabytes() -> float:
    """Growth of the peak memory of a process by a run of seven joints over 60 s stored at 1 kHz [MB]; Linux only.

    Raises:
        RuntimeError: another run than was meant, or a growth below the run's own arrays: the meter is broken.
    """
    joints, samples, growth, held = _python(MEMORY)
    if (joints, samples) != (7, 60001):
        raise RuntimeError(f"not the run that was meant: {joints} joints, {samples} samples")
    if growth < 0.9 * held:
        raise RuntimeError(f"memory grew by {growth:.1f} MB, and the run alone holds {held:.1f} MB")
    return growth


def _python(code: str) -> list[float]:
    done = subprocess.run(
        [sys.executable, "-c", code], cwd=Path(__file__).parent, capture_output=True, text=True, check=True
    )
    numbers: list[float] = json.loads(done.stdout)
    return numbers
