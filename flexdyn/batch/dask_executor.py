"""Chunks of a study on Dask distributed: the scheduler gets only small tasks and small answers."""

from __future__ import annotations

import itertools
import logging
import pickle
import secrets
import socket
import warnings
from collections.abc import Iterable, Iterator
from contextlib import suppress
from pathlib import Path
from queue import Empty, SimpleQueue
from typing import Any, Self

from flexdyn.batch.chunk import Done, Task
from flexdyn.errors import FlexdynError, InputError, needed

_LOGS = tuple(logging.getLogger(f"distributed.{name}") for name in ("client", "batched"))
"""Loggers that print tracebacks when the scheduler stops."""
TASKS_AHEAD = 512
"""Tasks that the scheduler has at a time: enough for as many threads, and a few MB at most."""
SCHEDULER_PATIENCE = 10.0
"""Time to wait for an answer of the scheduler [s]."""
LOOK = 2.0
"""Interval at which to check that the scheduler still answers while no result arrives [s]."""


class Dask:
    """Workers of a Dask cluster; a context manager.

    A task is pickled here and unpickled on a worker, so that the scheduler needs no flexdyn. If a worker stops, another
    one does its chunks; a chunk is reported once. The workers must see the store's folder under the same path.

    Args:
        where: of the scheduler: an address such as ``tcp://10.0.0.1:8786``, a ``distributed.Client``, or a cluster
            object, such as those of dask-jobqueue and dask-kubernetes.
        ahead: number of tasks that the scheduler has at a time.

    Raises:
        InputError: it is none of these.
    """

    def __init__(self, where: Any, *, ahead: int = TASKS_AHEAD) -> None:
        if not isinstance(where, str) and not hasattr(where, "scheduler_address") and not _is_client(where):
            remedy = "give an address, a cluster or a distributed.Client"
            raise InputError("no scheduler", key="scheduler", value=where, remedy=remedy)
        self._where = where
        self._ahead = ahead
        self._client: Any = None
        self._levels: list[int] = []

    def __enter__(self) -> Self:
        """Connect.

        Raises:
            InputError: no scheduler answers there.
            MissingExtra: distributed is not installed.
        """
        self._client = self._where if _is_client(self._where) else _connect(self._where)
        self._levels = [log.level for log in _LOGS]
        for log in _LOGS:
            log.setLevel(logging.CRITICAL)
        if getattr(self._client, "asynchronous", False):
            raise InputError("an asynchronous client", key="scheduler", remedy="give the address of its scheduler")
        if not self._client.scheduler_info(n_workers=-1)["workers"]:
            warnings.warn(f"{self._name} has no workers yet; waiting for them", stacklevel=2)
        return self

    def __exit__(self, *error: object) -> None:
        """Disconnect; a client that the user gave stays open."""
        if self._client is not self._where:
            with suppress(Exception):  # a scheduler that has stopped cannot be informed
                self._client.close(timeout=1.0)
        self._client = None
        for log, level in zip(_LOGS, self._levels, strict=True):
            log.setLevel(level)

    def run(self, task: Task, chunks: Iterable[int]) -> Iterator[Done]:
        """Do a task for every chunk; answers come in the order in which the chunks are finished.

        Args:
            task: called with the number of a chunk on a worker.
            chunks: their numbers.

        Yields:
            The result of the task for each chunk.

        Raises:
            FlexdynError: the scheduler has stopped, or a chunk cannot be done.
        """
        packed, name = pickle.dumps(task), f"flexdyn-{secrets.token_hex(8)}"
        waiting, done = iter(chunks), SimpleQueue[Any]()
        known: dict[str, tuple[Any, int]] = {}
        try:
            for chunk in itertools.islice(waiting, self._ahead):
                known |= self._submitted(name, packed, chunk, done)
            while known:
                future = self._next(done)
                answer = self._answer(future, known.pop(future.key)[1])
                for following in itertools.islice(waiting, 1):
                    known |= self._submitted(name, packed, following, done)
                yield answer
        finally:
            with suppress(Exception):
                self._client.cancel([future for future, _ in known.values()], force=True)

    @property
    def _name(self) -> str:
        address = getattr(getattr(self._client, "scheduler", None), "address", None)
        return f"the scheduler at {address or self._where}"

    def _submitted(self, name: str, packed: bytes, chunk: int, done: SimpleQueue[Any]) -> dict[str, tuple[Any, int]]:
        """The future of a chunk, by its key; it is put into `done` when it is finished."""
        call = pickle.dumps(_Call(packed, chunk))
        try:
            future = self._client.submit(pickle.loads, call, key=f"{name}-{chunk}", pure=False)
        except Exception as error:  # comm errors of several kinds
            raise self._gone() from error
        future.add_done_callback(done.put)
        return {future.key: (future, chunk)}

    def _next(self, done: SimpleQueue[Any]) -> Any:
        while True:
            try:
                return done.get(timeout=LOOK)
            except Empty:
                if self._client.status != "running":
                    raise self._gone() from None

    def _answer(self, future: Any, chunk: int) -> Any:
        """The result of a task.

        Raises:
            FlexdynError: there is no result; the message says why.
        """
        import distributed
        from distributed.comm import CommClosedError

        try:
            return future.result()
        except FlexdynError:
            raise
        except distributed.KilledWorker as error:
            remedy = "see the workers' logs; too little memory is the usual reason"
            raise FlexdynError(f"chunk {chunk} ended {error.allowed_failures + 1} workers; {remedy}") from None
        except (distributed.CancelledError, CommClosedError) as error:
            raise self._gone() from error
        except ModuleNotFoundError as error:
            if error.name != "flexdyn":
                raise
            remedy = "install the version that is used here on all of them"
            raise InputError("a worker has no flexdyn", key="scheduler", remedy=remedy) from None

    def _gone(self) -> FlexdynError:
        remedy = "finished chunks are stored: continue with --resume (resume=True)"
        return FlexdynError(f"{self._name} cannot be reached any more; {remedy}")


class _Call:
    """A chunk to be done; it is pickled, and unpickled on the worker that does it."""

    def __init__(self, packed: bytes, chunk: int) -> None:
        self._packed, self._chunk = packed, chunk

    def __reduce__(self) -> tuple[Any, ...]:
        return (work, (_version(), self._packed, self._chunk))


def work(version: str, packed: bytes, chunk: int) -> Any:
    """Do a chunk; called on a worker.

    Args:
        version: of flexdyn where the study was started.
        packed: the pickled task.
        chunk: its number.

    Raises:
        InputError: this worker has another version, or does not see the store.
    """
    if version != _version():
        problem = f"a worker has flexdyn {_version()}, and the study was started with {version}"
        raise InputError(problem, key="scheduler", remedy="install the same on all of them")
    task = pickle.loads(packed)  # noqa: S301 - our own task, sent by the user's own client
    if not Path(task.store).is_dir():
        problem = f"the worker {socket.gethostname()} does not see the store"
        raise InputError(problem, file=task.store, remedy="put it where all workers see it under the same path")
    return task(chunk)


def _version() -> str:
    from flexdyn import __version__

    return __version__


def _is_client(where: Any) -> bool:
    """Whether it is a distributed.Client; False if distributed is not installed."""
    try:
        import distributed
    except ImportError:
        return False
    return isinstance(where, distributed.Client)


def _connect(where: Any) -> Any:
    """A client of the scheduler at this address; refuses one that does not answer."""
    with needed("dask.distributed", "batch"):
        import distributed
        from distributed.comm.addressing import resolve_address
    try:
        if isinstance(where, str):
            resolve_address(where)  # a client with a wrong address would leave threads behind
        client: Any = distributed.Client
        return client(where, timeout=SCHEDULER_PATIENCE, set_as_default=False)
    except (OSError, TimeoutError, ValueError, ImportError) as error:
        reason = str(error).splitlines()[0] if str(error) else type(error).__name__
        remedy = "start one with: dask scheduler"
        raise InputError(f"no scheduler answers ({reason})", key="scheduler", value=str(where), remedy=remedy) from None
