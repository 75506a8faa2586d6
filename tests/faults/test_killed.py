"""kill -9 at every step of a save: the old file is there whole, or the new one is, and the next save succeeds."""

from __future__ import annotations

import json
import pickle
import shutil
import signal
import subprocess
import sys
from pathlib import Path

import pytest

import flexdyn as fd
from flexdyn.records import SUFFIXES
from tests.diagnose import slides
from tests.faults.writers import contents, writers

HOOK = """
import os, pickle, sys
def hook(event, arguments):
    global left
    if event in ("open", "os.rename", "os.remove", "os.mkdir") and str(arguments[0]).startswith(folder):
        left -= 1
        if left == 0:
            os.kill(os.getpid(), 9)
"""
"""Kills its process just before step `left` in `folder`."""
SERVER = f"""{HOOK}
with open(sys.argv[1], "rb") as stream:
    save, place = pickle.load(stream)
folder = str(place.parent)
save(place)  # what it imports is there for every child
os.write(1, b"ready\\n")
for line in sys.stdin:
    left = int(line)
    child = os.fork()
    if child == 0:
        sys.addaudithook(hook)
        save(place)
        os._exit(0)
    os.write(1, b"%d\\n" % os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]))
"""
"""For every number that it reads, a process that saves and is killed just before its step of that number."""
ALL_NAMES = [*SUFFIXES, "run", "model", "plot.png", "plot.html", "report"]
QUICK = (".csv", ".npz", ".mat", ".db3", "run", "model", "report")
"""One of each way to write, for CI; the others have the mark slow."""
NAMES = [name if name in QUICK else pytest.param(name, marks=pytest.mark.slow) for name in ALL_NAMES]
DIAGNOSIS = f"""{HOOK}
from flexdyn.cli import main
left, folder = int(sys.argv[1]), sys.argv[2]
sys.addaudithook(hook)
os._exit(main(["diagnose", "arm.yaml", "log.npz", "-o", folder]))
"""
"""`flexdyn diagnose`, killed just before its step of a number in the folder of the report."""


@pytest.mark.parametrize("name", NAMES)
def test_killed_while_it_saves(tmp_path: Path, name: str) -> None:
    """Steps are what Python asks of the system: to open, to rename and to remove files, and to make folders."""
    write = writers()[name]
    place = tmp_path / "there" / write.name
    place.parent.mkdir()
    write.new(place)
    new = contents(place)
    write.old(place)
    old = contents(place)
    assert old != new
    (tmp_path / "job").write_bytes(pickle.dumps((write.new, place)))
    seen: list[set[str]] = []
    words = [sys.executable, "-c", SERVER, str(tmp_path / "job")]
    with subprocess.Popen(words, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True, bufsize=1) as server:
        assert server.stdin is not None
        assert server.stdout is not None
        assert server.stdout.readline() == "ready\n"
        for step in range(1, 100):
            _restore(place, old)
            server.stdin.write(f"{step}\n")
            code = int(server.stdout.readline())
            seen.append(_whole(place, old, new, dated=name == ".mat"))
            assert [path.name for path in place.parent.iterdir() if path.name[0] != "."] == [place.name]
            if code == 0:
                break
            assert code == -signal.SIGKILL
        server.stdin.close()
    assert code == 0
    assert len(seen) > 3
    assert seen[0] == {"old"}
    assert seen[-1] == {"new"}


@pytest.mark.slow
def test_a_diagnosis_killed_while_it_writes(tmp_path: Path) -> None:
    """`flexdyn diagnose -o` into the folder of an earlier report: each of its files is the old one, or a new one."""
    fd.save_model(slides.model(tmp_path), tmp_path / "arm.yaml")
    fd.write_recording(slides.recording(lambda v: 5.0 * v, seconds=5.0), tmp_path / "log.npz")
    place = tmp_path / "report"
    writers()["report"].old(place)
    old, code, steps = contents(place), -signal.SIGKILL, 0
    while code == -signal.SIGKILL:
        steps += 1
        _restore(place, old)
        words = [sys.executable, "-c", DIAGNOSIS, str(steps), str(place)]
        code = subprocess.run(words, cwd=tmp_path, capture_output=True, check=False).returncode
        found = {path.name: path.read_bytes() for path in place.iterdir() if path.name[0] != "."}
        for name, content in found.items():
            assert content == old.get(name) or _is_whole_and_new(place / name), (steps, name)
        assert steps > 1 or found == old
    assert code == 0
    assert steps > 5
    assert all(found[name] != old.get(name) for name in ("report.json", "report.html", "model.yaml"))
    assert not [path for path in place.iterdir() if path.name[0] == "."]


def _is_whole_and_new(path: Path) -> bool:
    """Whether it is a file of the diagnosis of the slide, to its end."""
    text = path.read_text(encoding="utf-8")
    if path.name == "report.json":
        return "lift" in json.loads(text)["errors"]
    if path.name == "report.html":
        return "lift" in text and text.rstrip().endswith("</html>")
    read = fd.load_robot if path.suffix == ".urdf" else fd.load_model
    return tuple(read(path).joint_names) == ("lift",)


def _restore(place: Path, files: dict[str, bytes]) -> None:
    """The old files, and no others."""
    folder = place if place.is_dir() else place.parent
    for path in folder.iterdir():
        shutil.rmtree(path) if path.is_dir() else path.unlink()
    for name, content in files.items():
        (folder / name).write_bytes(content)


def _whole(place: Path, old: dict[str, bytes], new: dict[str, bytes], *, dated: bool) -> set[str]:
    """Which contents the files have, each of them to the last byte; hidden files are what a killed process left.

    Args:
        place: of the file, or of the folder of a report.
        old: files before the save.
        new: files after one.
        dated: the time of the save stands in the first 116 bytes.
    """
    found = {name: content for name, content in contents(place).items() if not name.startswith(".")}
    kinds = set()
    for name in old.keys() | new.keys():
        begin = 116 if dated else 0
        content = found.pop(name, b"")[begin:]
        assert content in (old.get(name, b"")[begin:], new.get(name, b"")[begin:]), name
        if old.get(name) != new.get(name):
            kinds.add("old" if content == old.get(name, b"")[begin:] else "new")
    assert not found
    return kinds
