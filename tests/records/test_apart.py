"""The process that reads HDF5: whatever a file does to it, the caller gets a table or one line, here and in workers."""

from __future__ import annotations

import multiprocessing
import os
import re
import signal
import subprocess
import sys
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from flexdyn.errors import InputError
from flexdyn.records import Recording, read_recording, write_recording
from flexdyn.records.apart import caller
from flexdyn.records.request import Request

T = np.arange(5.0)
REC = Recording(T, {"q.a": T, "tau.a": -T}, meta={"a": [1, {"b": None}]})

READER = """
import os, signal, time
from flexdyn.records.table import Table

def library():
    pass

def read_here(path, request):
    deed = open(path).read()
    if deed == "progress":
        request.report(0.5)
        return Table()
    exec(deed)
"""
"""A reader that does what its file says: crash, wait, take memory."""


@pytest.fixture
def deed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Any]:
    """What the caller is told where reading does this."""
    (tmp_path / "a_reader_that_fails.py").write_text(READER)
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.setattr(caller, "_idle", {})

    def told(code: str) -> str:
        (tmp_path / "file").write_text(code)
        with pytest.raises(InputError) as caught:
            caller.read_apart("a_reader_that_fails", tmp_path / "file", Request())
        assert str(caught.value).isprintable()
        return caught.value.problem

    yield told
    caller._release_all(caller._Server.end)


@pytest.fixture
def file(tmp_path: Path) -> Path:
    """A good file."""
    write_recording(REC, tmp_path / "log.h5")
    return tmp_path / "log.h5"


def test_crashes_are_one_line_and_the_next_file_is_read(deed: Any, file: Path) -> None:
    """Every way to die is answered, and leaves nothing behind that the next file would meet."""
    assert "(SIGSEGV)" in deed("os.kill(os.getpid(), signal.SIGSEGV)")
    assert "(SIGABRT)" in deed("os.abort()")
    assert deed("os._exit(3)").startswith("the library that reads it crashed")
    assert deed("os.write(1, b'x' * 100)").startswith("the library that reads it crashed")
    assert deed("os.write(1, (3).to_bytes(8, 'little') + b'[1]'); os._exit(0)").startswith("the library that reads")
    assert "x" in deed("from flexdyn.errors import InputError; raise InputError('x')")
    assert read_recording(file) == REC


def test_time_and_memory_are_bounded(deed: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    """A file that computes or waits for ever, or takes all memory, comes to an end."""
    assert re.fullmatch(r"reading it takes more than 1073\d{6} bytes of memory", deed("bytearray(2**33)"))
    monkeypatch.setattr("flexdyn.records.apart.server.COMPUTING_SECONDS", 1)
    assert deed("while True: pass") == "reading it takes more than 1 s of computing, or 10 s in all"
    monkeypatch.setattr("flexdyn.records.apart.server.WAITING", 1)
    assert "s in all" in deed("signal.alarm(1); time.sleep(60)")


def test_progress_is_told_and_may_stop_the_reading(tmp_path: Path, deed: Any) -> None:
    """What the caller's own function raises reaches the caller, and the next file is read all the same."""
    told: list[float] = []
    (tmp_path / "file").write_text("progress")
    caller.read_apart("a_reader_that_fails", tmp_path / "file", Request(progress=told.append))
    assert told == [0.5]

    def stop(share: float) -> None:
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        caller.read_apart("a_reader_that_fails", tmp_path / "file", Request(progress=stop))
    caller.read_apart("a_reader_that_fails", tmp_path / "file", Request(progress=told.append))
    assert told == [0.5, 0.5]


def test_no_interpreter_is_said(file: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Where no process can be started, the line says which one was tried."""
    monkeypatch.setattr(caller, "_idle", {})
    monkeypatch.setattr(sys, "executable", "/no/python")
    with pytest.raises(InputError, match=r"no process could be started to read the file; .* by /no/python"):
        read_recording(file)


def test_the_process_is_kept_and_threads_have_their_own(file: Path) -> None:
    """One process serves one file after the other; threads do not wait for each other."""
    assert read_recording(file) == REC
    (module,) = [name for name in caller._idle if name.endswith("hdf5.file")]
    first = caller._idle[module][-1].process.pid
    assert read_recording(file) == REC
    assert caller._idle[module][-1].process.pid == first
    with ThreadPoolExecutor(4) as pool:
        assert list(pool.map(read_recording, [file] * 20)) == [REC] * 20
    assert len(caller._idle[module]) <= 5


def test_a_process_that_was_ended_is_replaced(file: Path) -> None:
    """Whatever ended the idle process (the system short of memory, an administrator): the next file says so once."""
    assert read_recording(file) == REC
    (module,) = [name for name in caller._idle if name.endswith("hdf5.file")]
    for server in caller._idle[module]:
        os.killpg(server.process.pid, signal.SIGKILL)
        server.process.wait()
    assert read_recording(file) == REC


@pytest.mark.parametrize("method", ["spawn", "fork"])
@pytest.mark.filterwarnings("ignore::DeprecationWarning")
def test_daemonic_processes_read_too(file: Path, method: str) -> None:
    """Dask's workers are daemonic, and may not have children of multiprocessing."""
    read_recording(file)  # the child of a fork finds a process that is not its own
    context: Any = multiprocessing.get_context(method)
    with context.Pool(1) as pool:  # its processes are daemonic
        assert pool.apply_async(read_recording, (file,)).get(timeout=120) == REC
    assert read_recording(file) == REC


def test_nothing_is_left_when_the_program_ends(file: Path) -> None:
    """The process goes with the one that started it, however that ends."""
    code = (
        "import os, sys, flexdyn as fd; from flexdyn.records.apart import caller;"
        "fd.read_recording(sys.argv[1]);"
        "print(*(server.process.pid for every in caller._idle.values() for server in every), flush=True);"
        "os._exit(0) if sys.argv[2] == 'sudden' else None"
    )
    for way in ("sudden", "orderly"):
        command = [sys.executable, "-W", "error", "-c", code, str(file), way]
        done = subprocess.run(command, capture_output=True, text=True, check=True)
        assert done.stderr == ""
        pid = int(done.stdout)
        for _ in range(200):
            if not os.path.exists(f"/proc/{pid}"):
                break
            signal.sigtimedwait([], 0.05)
        assert not os.path.exists(f"/proc/{pid}"), way
