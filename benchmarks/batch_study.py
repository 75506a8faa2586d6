"""The batch as a study: `fd.run_study` in fresh processes, whose time, memory and disk are looked at."""

from __future__ import annotations

import json
import subprocess
import sys
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from pathlib import Path
from tempfile import mkdtemp
from typing import Any

from batch_problem import DURATION, Batch

import flexdyn as fd
from flexdyn.io.yaml import dump_yaml

RATE = 20.0  # Hz, of what is stored
METRICS = ("tip_deflection_max",)

# VmHWM and not ru_maxrss: see footprint.py.
CHILD = """
import json, sys, time
begin = time.perf_counter()
import flexdyn as fd
import zarr
study, out, workers = sys.argv[1], sys.argv[2], int(sys.argv[3])
fd.load_model("scara_two_link")
ready = time.perf_counter()
used = time.process_time()
results = fd.run_study(study, out, workers=workers)
seconds, used = time.perf_counter() - ready, time.process_time() - used
with open("/proc/self/status") as status:
    peak = next(int(line.split()[1]) * 1024 for line in status if line.startswith("VmHWM"))
print(json.dumps([ready - begin, seconds, used, peak / 1e6, results.study.chunks, len(results.failed)]))
"""


@dataclass(frozen=True)
class Measured:
    """One study in a process of its own.

    Attributes:
        runs: in it.
        start_seconds: until flexdyn and zarr are imported and a robot is loaded.
        seconds: of the study.
        processor_seconds: of all threads.
        peak_megabytes: of the process.
        chunks: that the store is cut into.
        store_megabytes: on disk.
        store_files: likewise.
    """

    runs: int
    start_seconds: float
    seconds: float
    processor_seconds: float
    peak_megabytes: float
    chunks: int
    store_megabytes: float
    store_files: int

    def to_dict(self) -> dict[str, Any]:
        """As the result file writes it, with the cost of a run."""
        content = {key: float(f"{value:.4g}") for key, value in asdict(self).items()}
        return content | {"microseconds_per_run": float(f"{1e6 * self.seconds / self.runs:.4g}")}


def measured(
    place: Path, batch: Batch, solver: Mapping[str, Any], runs: int, workers: int, *, numbers: bool
) -> Measured:
    """Run a study.

    Args:
        place: a folder that the study and its store stay in: for half a minute ext4 looks at every file that was
            deleted before it makes a new one, and the studies to come would pay for those that were removed.
        batch: whose model and command it takes.
        solver: as a study file writes it.
        runs: how many.
        workers: threads.
        numbers: stiffness, rotor inertia and friction levels vary too.

    Raises:
        RuntimeError: a run failed, or the whole study did.
    """
    folder = Path(mkdtemp(dir=place))
    study, out = _written(folder, batch, solver, runs, numbers=numbers), folder / "out.zarr"
    command = [sys.executable, "-c", CHILD, str(study), str(out), str(workers)]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode:
        raise RuntimeError(done.stderr)
    start, seconds, processor, peak, chunks, failed = json.loads(done.stdout)
    if failed:
        raise RuntimeError(f"{failed} runs failed")
    sizes = [path.stat().st_size for path in out.rglob("*") if path.is_file()]
    return Measured(runs, start, seconds, processor, peak, chunks, sum(sizes) / 1e6, len(sizes))


def _written(folder: Path, batch: Batch, solver: Mapping[str, Any], runs: int, *, numbers: bool) -> Path:
    """The study file, with model and command beside it."""
    names = batch.model.joint_names
    fd.save_model(batch.model, folder / "model.yaml")
    t, tau = batch.command.t, batch.command.values
    channels = {f"tau.{name}": tau[:, j] for j, name in enumerate(names)}
    fd.write_recording(fd.Recording(t, channels), folder / "command.csv")
    vary: dict[str, Any] = {f"initial.q.{name}": {"uniform": [-1.5, 1.5]} for name in names}
    if numbers:
        for name, joint in batch.model.joints.items():
            vary[f"joints.{name}.stiffness"] = {"uniform": _around(joint.stiffness)}
            vary[f"joints.{name}.rotor_inertia"] = {"uniform": _around(joint.rotor_inertia)}
        for i, effect in enumerate(batch.model.effects):
            if isinstance(effect, fd.effects.CoulombFriction):
                vary[f"effects[{i}].level"] = {"uniform": _around(effect.level)}
    content = {
        "flexdyn_study": 1,
        "model": "model.yaml",
        "command": "command.csv",
        "duration": DURATION,
        "rate": RATE,
        "solver": dict(solver),
        "runs": runs,
        "seed": 7,
        "vary": vary,
        "keep": ["q", "theta"],
        "metrics": list(METRICS),
    }
    path = folder / "study.yaml"
    path.write_text(dump_yaml(content), encoding="utf-8")
    return path


def _around(value: float) -> list[float]:
    return [0.8 * value, 1.2 * value]
