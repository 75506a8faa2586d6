"""A disk that is full and a folder that may not be written to: one line, and the old file stays to the last byte."""

from __future__ import annotations

import os
import resource
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

import flexdyn as fd
from flexdyn.records import SUFFIXES
from tests.faults.writers import Writer, contents, writers

NAMES = [*SUFFIXES, "run", "model", "plot.png", "plot.html", "report"]


@pytest.fixture(scope="module")
def every() -> dict[str, Writer]:
    """Made once."""
    found = writers()
    assert list(found) == NAMES
    return found


@contextmanager
def largest_file(size: int) -> Iterator[None]:
    """No file may grow beyond a size [bytes]: the system refuses as it does on a full disk.

    Of modules that are imported meanwhile Python would leave bytecode that is cut off.
    """
    before, kept = resource.getrlimit(resource.RLIMIT_FSIZE), sys.dont_write_bytecode
    sys.dont_write_bytecode = True
    resource.setrlimit(resource.RLIMIT_FSIZE, (size, before[1]))
    try:
        yield
    finally:
        sys.dont_write_bytecode = kept
        resource.setrlimit(resource.RLIMIT_FSIZE, before)


@contextmanager
def small_disk(folder: Path, size: str) -> Iterator[Path]:
    """A file system of its own, which only root may mount."""
    folder.mkdir()
    words = ["mount", "-t", "tmpfs", "-o", f"size={size}", "none", str(folder)]
    if os.geteuid() != 0 or subprocess.run(words, capture_output=True, check=False).returncode != 0:
        pytest.skip("mounting is not allowed here")
    try:
        yield folder
    finally:
        subprocess.run(["umount", "-l", str(folder)], check=False)


def refused(write: Writer, place: Path, words: str) -> None:
    """The new content is refused in one line that names the place, and nothing of the old one is lost."""
    before = contents(place)
    assert before
    with pytest.raises(fd.InputError, match=words) as caught:
        write.new(place)
    assert "\n" not in str(caught.value)
    assert str(place) in str(caught.value)
    assert contents(place) == before
    assert [path.name for path in place.parent.iterdir()] == [place.name]


@pytest.mark.parametrize("name", NAMES)
def test_a_file_that_may_not_grow(tmp_path: Path, every: dict[str, Writer], name: str) -> None:
    """Refused after its first bytes; with room made, the next attempt succeeds."""
    place = tmp_path / every[name].name
    every[name].old(place)
    with largest_file(500):
        refused(every[name], place, r"cannot be written \((File too large|disk I/O error)\)")
    every[name].new(place)


@pytest.mark.parametrize("name", NAMES)
def test_a_disk_that_is_full(tmp_path: Path, every: dict[str, Writer], name: str) -> None:
    """A file system without a free block."""
    with small_disk(tmp_path / "disk", "40m") as disk:
        place = disk / every[name].name
        every[name].old(place)
        held = os.statvfs(disk)
        size = (held.f_blocks - held.f_bfree) * held.f_frsize
        subprocess.run(["mount", "-o", f"remount,size={size}", disk], check=True)
        refused(every[name], place, r"cannot be written \((No space left on device|database or disk is full)\)")


@pytest.mark.parametrize("name", NAMES)
def test_a_read_only_folder(tmp_path: Path, every: dict[str, Writer], name: str) -> None:
    """Root may write into any folder, but not on a disk that is mounted read-only."""
    root = os.geteuid() == 0
    words = r"cannot be (written|made) \((Read-only file system|Permission denied)\)"
    if root:
        with small_disk(tmp_path / "disk", "40m") as disk:
            every[name].old(disk / every[name].name)
            subprocess.run(["mount", "-o", "remount,ro", disk], check=True)
            refused(every[name], disk / every[name].name, words)
        return
    place = tmp_path / every[name].name
    every[name].old(place)
    folders = [folder for folder in (place, tmp_path) if folder.is_dir()]
    for folder in folders:
        folder.chmod(0o555)
    try:
        refused(every[name], place, words)
    finally:
        for folder in folders:
            folder.chmod(0o755)
