"""A study's store and runs side by side are the same, byte for byte, for any number of threads and any load."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path
from typing import Any, NamedTuple

import pytest

from tests.batch.studies import tree, write_study
from tests.load import busy_machine

WORK = """
import hashlib, sys
import numpy as np
import flexdyn as fd
for study in sys.argv[1:3]:
    fd.run_study(study, f"{sys.argv[3]}/{study.split('/')[-2]}.zarr", workers=int(sys.argv[4]))
model = fd.load_model("ur5")
starts = [np.linspace(-0.5, 0.5, 6) * k / 12 for k in range(12)]
runs = fd.simulate_many([model] * 12, None, 0.3, q0=starts, threads=int(sys.argv[4]))
signals = [getattr(run, name) for run in runs for name in ("q", "theta", "v", "omega", "tau_s")]
signals += [run.energy.kinetic for run in runs[:2]] + [fd.LinkSide(model).mass_matrix(runs[0].q)]
print(hashlib.sha256(b"".join(np.ascontiguousarray(each).tobytes() for each in signals)).hexdigest())
"""
COUNTS = ((1, 1), (2, 4), (4, 2))
"""Threads of the linear algebra, and threads that make runs."""


class Done(NamedTuple):
    """What a process of its own made: the files of its stores, and the digest of its runs."""

    store: dict[str, bytes]
    runs: str


def done(folder: Path, stores: str, blas: int, workers: int) -> Done:
    """The studies in a folder and the runs, by a process that reads its number of threads when it starts."""
    environment = {**os.environ, "OPENBLAS_NUM_THREADS": str(blas), "OMP_NUM_THREADS": str(blas)}
    (folder / stores).mkdir()
    paths = [*(folder / name / "study.yaml" for name in ("auto", "fixed")), folder / stores]
    command = [sys.executable, "-W", "ignore", "-c", WORK, *map(str, paths), str(workers)]
    said = subprocess.run(command, env=environment, check=True, capture_output=True, text=True).stdout
    return Done(tree(folder / stores), said.strip())


@pytest.fixture(scope="module")
def all_done(tmp_path_factory: pytest.TempPathFactory) -> list[Done]:
    """By different numbers of threads, and beside other work."""
    folder = tmp_path_factory.mktemp("bits")
    solvers: dict[str, Any] = {"auto": "auto", "fixed": {"name": "TimeStepping", "step": 1e-3}}
    for name, solver in solvers.items():
        write_study(folder / name, solver=solver)
    found = [done(folder, f"stores{blas}{workers}", blas, workers) for blas, workers in COUNTS]
    with busy_machine():
        found.append(done(folder, "beside", 1, 3))
    return found


def test_a_store_is_the_same(all_done: list[Done]) -> None:
    """Signals, metrics and metadata, by chunks of four runs that end in whatever order; two ways to make a chunk."""
    one, *others = (each.store for each in all_done)
    assert one
    assert others == [one] * 3


def test_runs_side_by_side_are_the_same(all_done: list[Done]) -> None:
    """Every signal of twelve runs, the energy ledger, and M(q)."""
    one, *others = (each.runs for each in all_done)
    assert len(one) == 64
    assert others == [one] * 3
