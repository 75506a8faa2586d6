"""Read a file in another process: even if the file crashes that process, the result is a table or one line.

The process is started at the first file and kept for the next; each thread that reads has its own process. It also
works in daemonic processes, which may not have children of multiprocessing.
"""

from __future__ import annotations

import atexit
import contextlib
import json
import os
import pickle
import signal
import subprocess
import sys
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

from flexdyn.errors import InputError
from flexdyn.records.apart.messages import Lost, received, received_error, received_table
from flexdyn.records.apart.server import SIGNALLED, WAITING, bytes_for, seconds_for
from flexdyn.records.request import Request
from flexdyn.records.table import Table

# The package's __init__ also loads the simulation, which no reader needs: an empty module replaces it.
_START = """\
import json, sys, types
module, package, sys.path[:] = json.loads(sys.stdin.buffer.readline())
sys.modules["flexdyn"] = types.ModuleType("flexdyn")
sys.modules["flexdyn"].__path__ = [package]
from flexdyn.records.apart.server import serve
serve(module)
"""
_PACKAGE = Path(__file__).resolve().parents[2]
_PIPE_BYTES = 2**20


class _Server:
    """A process that reads one file after the other.

    Attributes:
        between: whether it has answered all requests, and no part of an answer is left in the pipe.
    """

    def __init__(self, module: str) -> None:
        self.between = False
        # The code is the text above and the interpreter is this one: nothing from a file is executed.
        self.process: Any = subprocess.Popen(  # noqa: S603
            [sys.executable, "-I", "-c", _START],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            env=os.environ | {"OPENBLAS_NUM_THREADS": "1"},  # forking needs a single thread
            cwd="/",
            start_new_session=True,
        )
        _enlarge(self.process.stdout)
        self._say([module, str(_PACKAGE), [os.path.abspath(entry) for entry in sys.path]])
        if self._heard()[0] != "ready":
            raise Lost

    def table(self, path: Path, request: Request, on_disk: int) -> Table:
        """The table of a file.

        Raises:
            InputError: the error that the reader reports.
            Lost: the process ended, or its answer is not valid.
        """
        self.between = False
        limits = {"seconds": seconds_for(on_disk), "bytes": bytes_for(on_disk)}
        packed = pickle.dumps(replace(request, progress=None)).hex()
        self._say({"path": os.path.abspath(path), "request": packed, **limits})
        kind, content = self._heard()
        while kind == "progress":
            request.report(float(content))
            kind, content = self._heard()
        table = received_table(self.process.stdout, content, on_disk) if kind == "table" else None
        self.between = True
        if table is not None:
            return table
        raise received_error(content) if kind == "error" else _too_much(on_disk)

    def end(self) -> int:
        """End the process and its child; return its exit code, which is its own if it had ended before."""
        for stream in (self.process.stdin, self.process.stdout):
            with contextlib.suppress(OSError):  # the last message may not have reached it
                stream.close()
        try:
            code = self.process.wait(0.5)
        except subprocess.TimeoutExpired:
            os.killpg(self.process.pid, signal.SIGKILL)
            code = self.process.wait()
        return int(code)

    def forget(self) -> None:
        """Release it in a child of this process: it belongs to the parent."""
        self.process.stdin.close()
        self.process.stdout.close()
        self.process.returncode = 0

    def _heard(self) -> tuple[str, Any]:
        return received(self.process.stdout)

    def _say(self, content: Any) -> None:
        try:
            self.process.stdin.write(json.dumps(content).encode() + b"\n")
            self.process.stdin.flush()
        except OSError:
            raise Lost from None


_idle: dict[str, list[_Server]] = {}


def read_apart(module: str, path: Path, request: Request) -> Table:
    """Read a file in another process.

    Args:
        module: whose `read_here` reads it.
        path: of the file.
        request: what to read; its progress is reported in this process.

    Raises:
        InputError: the error that the reader reports, or the file crashed the process, took too long or too much
            memory.
    """
    waiting = _idle.setdefault(module, [])
    on_disk = os.path.getsize(path)
    try:
        server = _alive(waiting) or _Server(module)
    except (OSError, Lost):
        remedy = f"such files are read in a process of their own, by {sys.executable}"
        raise InputError("no process could be started to read the file", remedy=remedy) from None
    try:
        return server.table(path, request, on_disk)
    except Lost:
        raise _ended(server.end(), on_disk) from None
    finally:
        if server.between:
            waiting.append(server)
        else:
            server.end()


def _alive(waiting: list[_Server]) -> _Server | None:
    """A process that waits for a file and has not ended meanwhile."""
    while waiting:
        server = waiting.pop()
        if server.process.poll() is None:
            return server
        server.end()
    return None


def _too_much(on_disk: int) -> InputError:
    problem = f"reading it takes more than {bytes_for(on_disk)} bytes of memory"
    return InputError(problem, remedy="the file is damaged, or its parts are too large: split it")


def _ended(code: int, on_disk: int) -> InputError:
    """The error for a file whose reader did not answer."""
    by = code - SIGNALLED
    if by in (signal.SIGXCPU, signal.SIGALRM):
        seconds = seconds_for(on_disk)
        problem = f"reading it takes more than {seconds} s of computing, or {WAITING * seconds} s in all"
        return InputError(problem, remedy="the file is damaged, or lies on a disk that does not answer")
    names = {int(known): known.name for known in signal.Signals}
    what = f" ({names[by]})" if by in names else ""
    return InputError(f"the library that reads it crashed{what}", remedy="the file is damaged: copy it again")


def _enlarge(stream: Any) -> None:
    """Make the pipe larger, if the system allows it: columns of a gigabyte go through it."""
    if sys.platform == "linux":
        import fcntl

        with contextlib.suppress(OSError):
            fcntl.fcntl(stream.fileno(), fcntl.F_SETPIPE_SZ, _PIPE_BYTES)


def _release_all(release: Callable[[_Server], Any]) -> None:
    for servers in _idle.values():
        for server in servers:
            release(server)
    _idle.clear()


atexit.register(_release_all, _Server.end)
os.register_at_fork(after_in_child=partial(_release_all, _Server.forget))
