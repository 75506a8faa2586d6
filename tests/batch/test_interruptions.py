"""What ends a study from outside: kill -9, Ctrl-C, a full disk, a folder that may not be written to."""

from __future__ import annotations

import json
import os
import re
import select
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

import flexdyn as fd
from flexdyn.errors import InputError
from tests.batch.studies import pieces, tree, write_study

KILLS = 20
SERVER = """
import os, sys, xarray, zarr, flexdyn
for line in sys.stdin:
    child = os.fork()
    if child == 0:
        os.setsid()
        flexdyn.run_study(sys.argv[1], sys.argv[2], workers=2, resume=True)
        os._exit(0)
    os.write(1, b"%d\\n" % child)
    os.write(1, b"%d\\n" % os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]))
"""
WHILE_IMPORTING = """
import os, signal, sys
class Interrupting:
    def find_spec(self, name, path=None, target=None):
        if name == {module!r}:
            os.kill(os.getpid(), signal.SIGINT)
sys.meta_path.insert(0, Interrupting())
"""
AT_THE_END = "import atexit, os, signal; atexit.register(lambda: os.kill(os.getpid(), signal.SIGINT))"
LIMITED = """
import resource, sys, flexdyn
sys.dont_write_bytecode = True  # of what it still imports, Python would leave files that are cut off
resource.setrlimit(resource.RLIMIT_FSIZE, (int(sys.argv[3]),) * 2)
flexdyn.run_study(sys.argv[1], sys.argv[2])
"""


def killed_or_done(server: subprocess.Popen[bytes], out: Path, stored: int, delay: float) -> bool:
    """Have the study done by a new process, and kill it with kill -9 some time after its store has some pieces.

    How far the study is decides, as its pace is the machine's.

    Args:
        server: forks a process for every line that it reads, and writes its number and how it ended.
        out: the store.
        stored: pieces that it must have.
        delay: after these are there [s].

    Returns:
        Whether it was killed.
    """
    assert server.stdin is not None
    assert server.stdout is not None
    server.stdin.write(b"\n")
    child = int(server.stdout.readline())
    while not (done := select.select([server.stdout], [], [], 1e-3)[0]) and len(pieces(out)) < stored:
        pass
    if not done and not select.select([server.stdout], [], [], delay)[0]:
        os.kill(child, signal.SIGKILL)
    code = int(server.stdout.readline())
    assert code in (0, -signal.SIGKILL)
    return code != 0


def test_kill_at_any_moment(tmp_path: Path) -> None:
    """20 times kill -9 at random moments, then --resume: the store of one uninterrupted run.

    A study that reaches its end before it is killed is held against the whole one too, and begun anew.
    """
    path = write_study(tmp_path, runs=120, chunk=2, duration=1.0, solver={"name": "TimeStepping", "step": 5e-4})
    fd.run_study(write_study(tmp_path / "warm"), tmp_path / "warm.zarr")
    begin = time.monotonic()
    fd.run_study(path, tmp_path / "whole.zarr", workers=2)
    span = time.monotonic() - begin
    whole, out = tree(tmp_path / "whole.zarr"), tmp_path / "out.zarr"
    total = len(pieces(tmp_path / "whole.zarr"))
    kills = halves = 0
    with subprocess.Popen(
        [sys.executable, "-c", SERVER, str(path), str(out)], stdin=subprocess.PIPE, stdout=subprocess.PIPE, bufsize=0
    ) as server:
        for progress, delay in np.random.default_rng(7).uniform(size=(1000, 2)):
            if killed_or_done(server, out, int(progress * total), 0.1 * span * delay):
                kills += 1
                halves += 0 < len(pieces(out)) < total
            else:
                assert tree(out) == whole
                shutil.rmtree(out)
            if kills == KILLS:
                break
        assert server.stdin is not None
        server.stdin.close()
    assert kills == KILLS
    assert halves > 0  # some met a study in the middle
    fd.run_study(path, out, workers=2, resume=True)
    assert tree(out) == whole
    assert not list(tmp_path.glob(".*"))


def test_the_disk_refuses(tmp_path: Path) -> None:
    """A limit that the system sets on files stands for a full disk: one line, and what was done is gone on with."""
    path = write_study(tmp_path, runs=40, chunk=20, rate=1000)
    fd.run_study(path, tmp_path / "whole.zarr")
    largest = max(file.stat().st_size for file in pieces(tmp_path / "whole.zarr"))
    words = [sys.executable, "-c", LIMITED, str(path), str(tmp_path / "out.zarr"), str(largest // 2)]
    err = subprocess.run(words, capture_output=True, text=True, check=False).stderr.splitlines()[-1]
    assert err.startswith("flexdyn.errors.InputError: ")
    assert (
        "out.zarr: cannot be written (File too large); finished chunks are stored; make room and continue with --resume"
        in err
    )
    fd.run_study(path, tmp_path / "out.zarr", resume=True)
    assert tree(tmp_path / "out.zarr") == tree(tmp_path / "whole.zarr")


@pytest.mark.skipif(os.geteuid() != 0, reason="only root can mount a small disk")
def test_a_full_disk(tmp_path: Path) -> None:
    """A disk of 200 kB that fills up: one line; with room made, the study goes on to the same end."""
    disk = tmp_path / "disk"
    disk.mkdir()
    mounted = subprocess.run(
        ["mount", "-t", "tmpfs", "-o", "size=200k", "none", str(disk)], capture_output=True, check=False
    )
    if mounted.returncode != 0:
        pytest.skip("mounting is not allowed here")
    try:
        path = write_study(tmp_path, runs=200, chunk=10)
        with pytest.raises(
            InputError, match=r"cannot be written \(No space left on device\); finished chunks are stored"
        ):
            fd.run_study(path, disk / "out.zarr")
        there = len(pieces(disk / "out.zarr"))
        subprocess.run(["mount", "-o", "remount,size=20m", str(disk)], check=True)
        seen: list[int] = []
        fd.run_study(path, disk / "out.zarr", resume=True, progress=lambda progress: seen.append(progress.done))
        assert there > 0
        assert seen[0] > 0  # some chunks were whole
        fd.run_study(path, tmp_path / "whole.zarr")
        assert tree(disk / "out.zarr") == tree(tmp_path / "whole.zarr")
    finally:
        subprocess.run(["umount", "-l", str(disk)], check=False)


def test_where_nothing_can_be_written(tmp_path: Path) -> None:
    """A folder that refuses, or is not there, is said before anything is done."""
    path = write_study(tmp_path)
    with pytest.raises(InputError, match=r"/proc/out\.zarr: cannot be written \(.*\); give another place"):
        fd.run_study(path, "/proc/out.zarr")
    with pytest.raises(InputError, match=r"no such folder.*make it first"):
        fd.run_study(path, tmp_path / "no" / "out.zarr")


@pytest.mark.skipif(os.geteuid() == 0, reason="root may write anywhere")
def test_a_read_only_folder(tmp_path: Path) -> None:
    """One line for a new store and for one to be gone on with; what is in it stays."""
    path = write_study(tmp_path / "study")
    fd.run_study(path, tmp_path / "out.zarr")
    pieces(tmp_path / "out.zarr")[0].unlink()
    before = tree(tmp_path / "out.zarr")
    for folder in (*(tmp_path / "out.zarr").glob("*/"), tmp_path):
        folder.chmod(0o555)
    try:
        for out in ("new.zarr", "out.zarr"):
            with pytest.raises(InputError, match=r"cannot be written \(Permission denied\)"):
                fd.run_study(path, tmp_path / out, resume=True)
        assert tree(tmp_path / "out.zarr") == before
    finally:
        for folder in (tmp_path, *(tmp_path / "out.zarr").glob("*/")):
            folder.chmod(0o755)


def flexdyn(*arguments: str | Path, before: str = "") -> subprocess.Popen[str]:
    """The command in a process of its own, maybe with Python to be done before."""
    code = f"{before}\nimport sys; from flexdyn_program import main; sys.exit(main())"
    words = [sys.executable, "-c", code, *map(str, arguments)]
    return subprocess.Popen(words, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)


def test_control_c(tmp_path: Path) -> None:
    """Exit 130, two lines that say how to go on, and a store that does go on to the same end."""
    path, out = write_study(tmp_path, runs=100, chunk=1, duration=2.0), tmp_path / "out.zarr"
    work = flexdyn("batch", path, "-o", out, "--workers", "2")
    while work.poll() is None and not (out.exists() and len(pieces(out)) > 10):
        time.sleep(0.01)
    work.send_signal(signal.SIGINT)
    _, err = work.communicate()
    assert work.returncode == 130
    lines = err.splitlines()
    assert lines == [
        f"flexdyn: finished runs are stored; continue with: flexdyn batch {path} -o {out} --resume",
        "flexdyn: interrupted",
    ]
    assert not list(out.rglob("*.partial"))
    done = fd.run_study(path, out, resume=True).summary().done
    assert done == 100
    fd.run_study(path, tmp_path / "whole.zarr")
    assert tree(out) == tree(tmp_path / "whole.zarr")


@pytest.mark.parametrize(
    ("module", "done"), [("numpy", False), ("pinocchio", False), ("flexdyn.cli.app", False), ("xarray", True)]
)
def test_control_c_while_something_is_imported(tmp_path: Path, module: str, done: bool) -> None:
    """Exit 130 and one line, as early as the first library is imported; after the runs one more says what is there."""
    path, out = write_study(tmp_path), tmp_path / "out.zarr"
    work = flexdyn("batch", path, "-o", out, before=WHILE_IMPORTING.format(module=module))
    words, err = work.communicate()
    said = [f"flexdyn: all runs are stored; see them with: flexdyn batch {out} --summary"] if done else []
    assert err.splitlines() == [*said, "flexdyn: interrupted"]
    assert (work.returncode, words) == (130, "")
    assert out.exists() == done
    assert fd.run_study(path, out, resume=True).summary().done == 12


def test_control_c_after_everything_is_said(tmp_path: Path) -> None:
    """While Python tidies up there is nothing left to interrupt: the study is done, and that is the exit code."""
    work = flexdyn("batch", write_study(tmp_path), "-o", tmp_path / "out.zarr", before=AT_THE_END)
    words, err = work.communicate()
    assert (work.returncode, err) == (0, "")
    assert "12 of 12 runs done" in words


def test_control_c_does_not_wait_for_the_chunk_in_work(tmp_path: Path) -> None:
    """A chunk that would take days is given up at once."""
    path = write_study(tmp_path, runs=2, chunk=1, duration=1e6, rate=1e-3, metrics=None)
    work = flexdyn("batch", path, "-o", tmp_path / "out.zarr", "--workers", "1")
    while work.poll() is None and not (tmp_path / "out.zarr").exists():
        time.sleep(0.01)
    time.sleep(0.3)
    work.send_signal(signal.SIGINT)
    try:
        work.communicate(timeout=60)  # it hangs here for days if it waits
    finally:
        work.kill()
    assert work.returncode == 130


@pytest.mark.slow
def test_progress_on_a_terminal(tmp_path: Path) -> None:
    """Runs done, rate and time left stand on stderr where that is a terminal, and stdout holds the results alone."""
    path = write_study(tmp_path, runs=60, chunk=3, duration=2.0)
    ours, theirs = os.openpty()
    words = [sys.executable, "-m", "flexdyn_program", "batch", str(path), "-o", str(tmp_path / "out.zarr"), "--json"]
    work = subprocess.Popen(words, stdout=subprocess.PIPE, stderr=theirs, text=True, env=os.environ | {"TERM": "xterm"})
    os.close(theirs)
    seen = b""
    while True:
        try:
            seen += os.read(ours, 4096)
        except OSError:  # the other end is closed
            break
    out = work.communicate()[0]
    os.close(ours)
    assert work.returncode == 0
    assert json.loads(out)["done"] == 60
    assert re.search(rb"study\.yaml: \d+ of 60 runs, [\d.]+ runs/s, \d+ s left", seen)
