"""A study's store and runs side by side are the same, byte for byte, for any number of threads and workers."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

from tests.batch.studies import tree, write_study

STUDY = """
import sys
import flexdyn as fd
fd.run_study(sys.argv[1], sys.argv[2], workers=int(sys.argv[3]))
"""
RUNS = """
import hashlib, sys
import numpy as np
import flexdyn as fd
model = fd.load_model("ur5")
starts = [np.linspace(-0.5, 0.5, 6) * k / 12 for k in range(12)]
runs = fd.simulate_many([model] * 12, None, 0.3, q0=starts, threads=int(sys.argv[3]))
signals = [getattr(run, name) for run in runs for name in ("q", "theta", "v", "omega", "tau_s")]
signals += [run.energy.kinetic for run in runs[:2]] + [fd.LinkSide(model).mass_matrix(runs[0].q)]
print(hashlib.sha256(b"".join(np.ascontiguousarray(each).tobytes() for each in signals)).hexdigest())
"""
COUNTS = ((1, 1), (2, 4), (4, 2))
"""Threads of the linear algebra, and threads that make runs."""


def said(script: str, blas: int, workers: int, *paths: Path) -> str:
    """What a process of its own prints, which reads its number of threads when it starts."""
    environment = {**os.environ, "OPENBLAS_NUM_THREADS": str(blas), "OMP_NUM_THREADS": str(blas)}
    command = [sys.executable, "-W", "ignore", "-c", script, *(map(str, paths or ("", ""))), str(workers)]
    return subprocess.run(command, env=environment, check=True, capture_output=True, text=True).stdout


@pytest.mark.parametrize("solver", ["auto", {"name": "TimeStepping", "step": 1e-3}], ids=["auto", "TimeStepping"])
def test_a_store_is_the_same(tmp_path: Path, solver: Any) -> None:
    """Signals, metrics and metadata, by chunks of four runs that end in whatever order."""
    study = write_study(tmp_path / "study", solver=solver)
    stores = []
    for blas, workers in COUNTS:
        store = tmp_path / f"store{blas}{workers}.zarr"
        said(STUDY, blas, workers, study, store)
        stores.append(tree(store))
    assert stores[0]
    assert stores[1:] == [stores[0]] * 2


def test_runs_side_by_side_are_the_same() -> None:
    """Every signal of twelve runs, the energy ledger, and M(q)."""
    one, *others = (said(RUNS, blas, workers) for blas, workers in COUNTS)
    assert len(one.strip()) == 64
    assert others == [one, one]
