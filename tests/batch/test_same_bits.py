"""A study's store and runs side by side are the same, byte for byte, for any number of threads and any load."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path
from typing import Any

from tests.batch.studies import tree, write_study
from tests.load import busy_machine

STUDY = """
import sys
import flexdyn as fd
for study in sys.argv[1:3]:
    fd.run_study(study, f"{sys.argv[3]}/{study.split('/')[-2]}.zarr", workers=int(sys.argv[4]))
"""
RUNS = """
import hashlib, sys
import numpy as np
import flexdyn as fd
model = fd.load_model("ur5")
starts = [np.linspace(-0.5, 0.5, 6) * k / 12 for k in range(12)]
runs = fd.simulate_many([model] * 12, None, 0.3, q0=starts, threads=int(sys.argv[1]))
signals = [getattr(run, name) for run in runs for name in ("q", "theta", "v", "omega", "tau_s")]
signals += [run.energy.kinetic for run in runs[:2]] + [fd.LinkSide(model).mass_matrix(runs[0].q)]
print(hashlib.sha256(b"".join(np.ascontiguousarray(each).tobytes() for each in signals)).hexdigest())
"""
COUNTS = ((1, 1), (2, 4), (4, 2))
"""Threads of the linear algebra, and threads that make runs."""


def said(script: str, blas: int, workers: int, *paths: Path) -> str:
    """What a process of its own prints, which reads its number of threads when it starts."""
    environment = {**os.environ, "OPENBLAS_NUM_THREADS": str(blas), "OMP_NUM_THREADS": str(blas)}
    command = [sys.executable, "-W", "ignore", "-c", script, *map(str, paths), str(workers)]
    return subprocess.run(command, env=environment, check=True, capture_output=True, text=True).stdout


def test_a_store_is_the_same(tmp_path: Path) -> None:
    """Signals, metrics and metadata, by chunks of four runs that end in whatever order; two ways to make a chunk."""
    solvers: dict[str, Any] = {"auto": "auto", "fixed": {"name": "TimeStepping", "step": 1e-3}}
    for name, solver in solvers.items():
        write_study(tmp_path / name, solver=solver)
    trees = []
    for blas, workers in COUNTS:
        stores = tmp_path / f"stores{blas}{workers}"
        stores.mkdir()
        said(STUDY, blas, workers, *(tmp_path / name / "study.yaml" for name in solvers), stores)
        trees.append(tree(stores))
    beside = tmp_path / "beside"
    beside.mkdir()
    with busy_machine():
        said(STUDY, 1, 3, *(tmp_path / name / "study.yaml" for name in solvers), beside)
    assert trees[0]
    assert [*trees[1:], tree(beside)] == [trees[0]] * 3


def test_runs_side_by_side_are_the_same() -> None:
    """Every signal of twelve runs, the energy ledger, and M(q)."""
    one, *others = (said(RUNS, blas, workers) for blas, workers in COUNTS)
    with busy_machine():
        others.append(said(RUNS, 1, 3))
    assert len(one.strip()) == 64
    assert others == [one] * 3
