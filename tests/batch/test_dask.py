"""Studies over a real Dask cluster: nothing lost, nothing twice, one clear line where it cannot go on."""

from __future__ import annotations

import importlib
import json
import re
import socket
import threading
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

import flexdyn as fd
from flexdyn.batch import dask_executor
from flexdyn.batch.dask_executor import Dask
from flexdyn.batch.progress import Progress
from flexdyn.batch.results import open_results
from flexdyn.batch.run_study import run_study
from tests.batch.cluster import Cluster, cluster
from tests.batch.small import pulse_study

pytest.importorskip("distributed")
pytestmark = pytest.mark.filterwarnings("ignore:the scheduler at .* has no workers yet")
SLOW = """
import os, pathlib, time
def slow(run):
    pathlib.Path(__file__).with_name(f"worked-{os.getpid()}").touch()
    time.sleep(0.01)
    return run.q[-1, 0]
"""
TASK = """
import os, time
from dataclasses import dataclass
@dataclass(frozen=True)
class Mark:
    store: str
    seconds: float
    def __call__(self, chunk):
        time.sleep(self.seconds)
        if chunk == 99:
            os.kill(os.getpid(), 9)
        if chunk == 98:
            raise OSError(28, "No space left on device")
        with open(os.path.join(self.store, f"done-{chunk}"), "a") as file:
            file.write(f"{os.getpid()} ")
        return chunk
"""
BLOCKED = """
import sys
class Blocked:
    def find_spec(self, name, path=None, target=None):
        if name == "flexdyn":
            raise ModuleNotFoundError("No module named 'flexdyn'", name="flexdyn")
sys.meta_path.insert(0, Blocked())
"""


@pytest.fixture(scope="module")
def workers(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Cluster]:
    """Two workers that nobody harms."""
    folder = tmp_path_factory.mktemp("cluster")
    (folder / "dask_marks.py").write_text(TASK, encoding="utf-8")
    with cluster(folder) as made:
        yield made


def marks(folder: Path, monkeypatch: pytest.MonkeyPatch) -> Any:
    """The class of tasks that leave a mark, importable here as on the workers."""
    monkeypatch.syspath_prepend(folder)
    return importlib.import_module("dask_marks").Mark


def contents(store: Path) -> dict[str, bytes]:
    """Every file of a store."""
    return {str(path.relative_to(store)): path.read_bytes() for path in store.rglob("*") if path.is_file()}


def test_a_study_is_that_of_threads(workers: Cluster, tmp_path: Path) -> None:
    """The store that two workers write is byte for byte that of threads of this process."""
    study = pulse_study(tmp_path)
    here = run_study(study, tmp_path / "here.zarr", workers=1)
    there = run_study(study, tmp_path / "there.zarr", scheduler=workers.address)
    assert contents(there.path) == contents(here.path)


def test_a_client_stays_open(workers: Cluster, tmp_path: Path) -> None:
    """A client does as well as an address, and is not closed."""
    import distributed

    with distributed.Client(workers.address, set_as_default=False) as client:
        results = run_study(pulse_study(tmp_path), tmp_path / "out.zarr", scheduler=client)
        again = run_study(pulse_study(tmp_path), tmp_path / "again.zarr", scheduler=client)
        assert client.status == "running"
    assert results.pending == again.pending == 0


def test_a_cluster_object(tmp_path: Path) -> None:
    """So does a cluster object, which dask-jobqueue's and dask-kubernetes' are kinds of."""
    import distributed

    loopback = dict.fromkeys(("dashboard_address", "worker_dashboard_address"), "127.0.0.1:0")
    with distributed.LocalCluster(n_workers=1, threads_per_worker=2, processes=False, **loopback) as made:
        results = run_study(pulse_study(tmp_path), tmp_path / "out.zarr", scheduler=made)
    assert results.pending == 0


def test_few_tasks_are_known_to_the_scheduler(
    workers: Cluster, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """However many chunks there are, they are handed over as others come back, each once."""
    mark = marks(workers.folder, monkeypatch)

    taken: list[int] = []
    chunks = (taken.append(k) or k for k in range(40))  # type: ignore[func-returns-value]
    with Dask(workers.address, ahead=5) as executor:
        for count, _ in enumerate(executor.run(mark(str(tmp_path), 0.0), chunks), start=1):
            assert len(taken) <= count + 5
    assert sorted(path.name for path in tmp_path.iterdir()) == sorted(f"done-{k}" for k in range(40))
    assert all(len(path.read_text().split()) == 1 for path in tmp_path.iterdir())


def test_what_a_worker_cannot_do_is_said_here(
    workers: Cluster, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """An error on a worker is that error here; what was in work besides is given up."""
    mark = marks(workers.folder, monkeypatch)

    with pytest.raises(OSError, match="No space left"), Dask(workers.address, ahead=4) as executor:
        list(executor.run(mark(str(tmp_path), 0.01), [0, 98, *range(1, 60)]))
    assert len(list(tmp_path.iterdir())) < 30


def test_a_worker_that_does_not_see_the_store(
    workers: Cluster, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A folder that only this machine has is said to be that, with the worker's name."""
    mark = marks(workers.folder, monkeypatch)
    line = rf"x\.zarr: the worker {re.escape(socket.gethostname())} does not see the store; put it where all workers"
    with pytest.raises(fd.InputError, match=line), Dask(workers.address) as executor:
        list(executor.run(mark(str(tmp_path / "x.zarr"), 0.0), range(3)))


def test_another_version_is_refused(workers: Cluster, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A worker with another flexdyn would give other numbers: one line, and nothing is done."""
    study = pulse_study(tmp_path)
    monkeypatch.setattr(dask_executor, "_version", lambda: "99.0")
    line = rf"scheduler: a worker has flexdyn {fd.__version__}, and the study was started with 99\.0; install the same"
    with pytest.raises(fd.InputError, match=line):
        run_study(study, tmp_path / "out.zarr", scheduler=workers.address)


def test_a_worker_without_flexdyn_is_refused(tmp_path: Path) -> None:
    """One line says it, and the scheduler itself needs no flexdyn either."""
    (tmp_path / "cluster").mkdir()
    (tmp_path / "cluster" / "sitecustomize.py").write_text(BLOCKED, encoding="utf-8")
    line = r"scheduler: a worker has no flexdyn; install the version that is used here on all of them"
    with cluster(tmp_path / "cluster", workers=1) as made, pytest.raises(fd.InputError, match=line):
        run_study(pulse_study(tmp_path), tmp_path / "out.zarr", scheduler=made.address)


def test_a_worker_is_killed_in_the_middle(tmp_path: Path) -> None:
    """Its chunks are done by the other: nothing is lost, nothing comes twice, and the store is that of threads."""
    (tmp_path / "own_slow.py").write_text(SLOW, encoding="utf-8")
    study = pulse_study(tmp_path, runs=100, chunk=4, metrics=["own_slow:slow"])
    (tmp_path / "study.yaml").write_text(json.dumps(study), encoding="utf-8")
    here = run_study(tmp_path / "study.yaml", tmp_path / "here.zarr", workers=2)
    seen: list[int] = []
    killed = threading.Event()
    with cluster(tmp_path) as made:

        def kill_one(now: Progress) -> None:
            seen.append(now.done)
            if not killed.is_set() and all((tmp_path / f"worked-{each.pid}").exists() for each in made.workers):
                killed.set()
                made.kill_worker(0)

        there = run_study(tmp_path / "study.yaml", tmp_path / "there.zarr", scheduler=made.address, progress=kill_one)
        assert made.workers[0].wait() == -9
    assert killed.is_set()
    assert (seen[0], seen[-1], len(seen)) == (0, 100, 26)
    assert contents(there.path) == contents(here.path)


def test_a_chunk_that_ends_every_worker(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """It is given up with one line rather than tried for ever."""
    (tmp_path / "dask_marks.py").write_text(TASK, encoding="utf-8")
    mark = marks(tmp_path, monkeypatch)
    monkeypatch.setenv("DASK_DISTRIBUTED__SCHEDULER__ALLOWED_FAILURES", "0")
    line = r"^chunk 99 ended 1 workers; see the workers' logs; too little memory is the usual reason$"
    with (
        cluster(tmp_path, workers=1) as made,
        Dask(made.address) as executor,
        pytest.raises(fd.FlexdynError, match=line),
    ):
        list(executor.run(mark(str(tmp_path), 0.0), [99]))


def test_a_scheduler_that_vanishes(tmp_path: Path) -> None:
    """One clear line; what was done is there to be used, and another cluster or none goes on from it."""
    study = pulse_study(tmp_path, runs=200)
    out = tmp_path / "out.zarr"
    with cluster(tmp_path) as made:
        timer = threading.Event()

        def kill(now: Progress) -> None:
            if now.done >= 20 and not timer.is_set():
                timer.set()
                made.kill_scheduler()

        with pytest.raises(
            fd.FlexdynError, match=r"^the scheduler at tcp://127\.0\.0\.1:\d+ cannot be reached any more; finished"
        ):
            run_study(study, out, scheduler=made.address, progress=kill)
    half = open_results(out).summary()
    assert 20 <= half.done < 200
    assert half.metrics[0].runs == half.done
    resumed = run_study(study, out, resume=True)
    assert contents(resumed.path) == contents(run_study(study, tmp_path / "whole.zarr").path)


def test_nobody_answers() -> None:
    """An address that is none, or where nothing listens, and an object that is no cluster."""
    cases = {
        "127.0.0.1": r"scheduler: no scheduler answers \(missing port number .*; start one with: dask scheduler",
        "nonsense://x": r"scheduler: no scheduler answers \(unknown address scheme",
    }
    for address, line in cases.items():
        with pytest.raises(fd.InputError, match=line), Dask(address):
            pass
    with pytest.raises(fd.InputError, match=r"scheduler: no scheduler, got 3; give an address, a cluster or"):
        Dask(3)


def test_a_scheduler_that_does_not_listen(monkeypatch: pytest.MonkeyPatch) -> None:
    """It is not waited for without end."""
    monkeypatch.setattr(dask_executor, "SCHEDULER_PATIENCE", 0.5)
    with pytest.raises(fd.InputError, match=r"no scheduler answers \(Timed out"), Dask("tcp://127.0.0.1:9"):
        pass
