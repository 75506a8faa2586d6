"""run_study: combines study, store and executor."""

from __future__ import annotations

import fcntl
import os
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from flexdyn.batch.chunk import Task
from flexdyn.batch.dask_executor import Dask
from flexdyn.batch.executors import Threads
from flexdyn.batch.progress import Meter, Progress
from flexdyn.batch.results import Results
from flexdyn.batch.store import Store, create, open_store
from flexdyn.batch.study import Study
from flexdyn.batch.studyfile import read_study, study_from_dict
from flexdyn.errors import InputError


def run_study(
    study: str | Path | Mapping[str, Any] | Study,
    out: str | Path,
    *,
    workers: int | None = None,
    scheduler: Any = None,
    resume: bool = False,
    progress: Callable[[Progress], None] | None = None,
) -> Results:
    """Make all runs of a study and store them chunk by chunk.

    Run k depends only on the study's seed and on k. If the process is killed, at most the chunks in progress are lost;
    `resume` makes the missing ones, and the store is then bit for bit that of one uninterrupted run.

    Args:
        study: path of a study file, its mapping (paths relative to the working folder), or a `Study`.
        out: folder of the Zarr store.
        workers: threads of this process; default: the processors it may use.
        scheduler: of Dask, instead: an address, a ``distributed.Client``, or a cluster object such as those of
            dask-jobqueue and dask-kubernetes.
        resume: continue the store if it exists.
        progress: called with a `Progress` at the start and after every chunk.

    Returns:
        The results in the store.

    Raises:
        InputError: a study that does not fit, a store that exists already or belongs to another study, a full disk.
        MissingExtra: zarr, dask or xarray is not installed.

    Example:
        >>> study = {"flexdyn_study": 1, "model": "scara_two_link", "duration": 0.5, "runs": 4, "seed": 1,
        ...          "vary": {"initial.v.elbow": {"normal": [-2.0, 0.3]}}, "metrics": ["tip_deflection_max"]}
        >>> results = fd.run_study(study, out="study.zarr")
        >>> results.dataset()["tip_deflection_max"].shape
        (4,)
    """
    whole = _study(study)
    executor = _executor(workers, scheduler)
    path = Path(out)
    with executor:
        is_new = not (resume and path.exists())
        store = _new(whole, path) if is_new else _same(whole, path)
        with _alone(store):
            chunks: Sequence[int] = range(whole.chunks)
            if not is_new:
                store.mend()
                chunks = list(store.missing())
            _work(executor, whole, store, chunks, progress or (lambda _: None))
    return Results(path, whole)


def _work(
    executor: Threads | Dask, study: Study, store: Store, chunks: Sequence[int], tell: Callable[[Progress], None]
) -> None:
    meter = Meter(study.count, study.count - sum(len(study.bounds(chunk)) for chunk in chunks))
    tell(meter.now())
    for done in executor.run(Task(study.to_text(), os.path.abspath(store.path)), chunks):
        tell(meter.add(done.runs, done.failed))
    store.sweep()  # left by a worker that was killed while another one did its chunk


def _study(study: Any) -> Study:
    if isinstance(study, Study):
        return study
    if isinstance(study, Mapping):
        return study_from_dict(study, Path.cwd())
    if isinstance(study, str | os.PathLike):
        return read_study(Path(study))
    raise InputError("the path of a study file is needed", key="study", value=study)


def _executor(workers: int | None, scheduler: Any) -> Threads | Dask:
    if scheduler is None:
        return Threads(workers)
    if workers is not None:
        remedy = "a cluster has its own workers: leave one of the two out"
        raise InputError("workers and a scheduler", key="workers", value=workers, remedy=remedy)
    return Dask(scheduler)


def _new(study: Study, path: Path) -> Store:
    if path.exists():
        remedy = "continue it with --resume (in Python resume=True), or remove it"
        raise InputError("it exists already", file=path, remedy=remedy)
    if not path.parent.is_dir():
        raise InputError("no such folder", file=path, value=str(path.parent), remedy="make it first")
    return create(study, path)


def _same(study: Study, path: Path) -> Store:
    """The store, if it belongs to this study.

    Raises:
        InputError: it does not; the message names the difference.
    """
    from flexdyn import __version__

    store = open_store(path)
    difference = study.difference(store.study)
    if difference is None and store.version != __version__:
        difference = f"flexdyn is {__version__} here and {store.version} there"
    if difference is not None:
        remedy = "write to another place, or remove this one"
        raise InputError(f"the store is of another study: {difference}", file=path, remedy=remedy)
    return Store(path, study, store.version)  # its files may be at another place now


@contextmanager
def _alone(store: Store) -> Iterator[None]:
    """Lock the store against other processes of this machine; the lock ends with this process.

    Raises:
        InputError: another process uses the store.
    """
    handle = os.open(store.path, os.O_RDONLY)
    try:
        try:
            fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            raise InputError("another process is at work on this store", file=store.path) from None
        except OSError:  # a network file system without locks: other processes cannot be excluded
            pass
        yield
    finally:
        os.close(handle)
