"""MATLAB files of version 5: `scipy.io.loadmat` in this process against the same function in our reading process.

Right on a sound file: the same numbers from both. Right on a damaged one: a result or an error of its own; a process
that ends is wrong.
"""

from __future__ import annotations

import contextlib
import os
import resource
import statistics
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import scipy.io
from comparison import ROUNDS, Case, Comparison

from flexdyn.errors import InputError
from flexdyn.records.matlab import file as mat_file
from flexdyn.records.request import Request

FLIPPED, HEADER = 500, 128
"""Bytes of the damaged file, of which one bit at a time is changed; they follow the header."""

MEMORY = 4 * 2**30
"""That a process may take which reads a damaged file [bytes]."""


def compare(data: Path) -> Comparison:
    """Both on the measured files that are there, on a large file and on damaged ones.

    Args:
        data: folder of the measured data.
    """
    cases, times = [], {}
    for path in sorted(data.glob("*/*.mat")):
        cases.append(Case(f"{path.parent.name}/{path.name}", "", _same(path)))
        times[path.name] = _times(path)
    with tempfile.TemporaryDirectory() as folder:
        large = Path(folder) / "large.mat"
        scipy.io.savemat(large, _log(100_000), oned_as="column")
        times["100,000 samples of 20 channels"] = _times(large)
        cases += _damaged(Path(folder))
    task = "MATLAB files of version 5, in a process of their own"
    return Comparison(task, mat_file.__name__, "SciPy, scipy.io.loadmat in the caller's process", cases, times)


def _times(path: Path) -> float:
    """Elapsed time of the library over ours, median of rounds: our work is done by another process."""
    _read(path)  # starts that process
    return statistics.median(
        _seconds(lambda: scipy.io.loadmat(path)) / _seconds(lambda: _read(path)) for _ in range(ROUNDS)
    )


def _seconds(work: Callable[[], object]) -> float:
    begin = time.perf_counter()
    work()
    return time.perf_counter() - begin


def _read(path: Path) -> dict[str, Any]:
    return mat_file.read(path, Request(mapped=True)).columns


def _same(path: Path) -> str:
    """Whether SciPy finds every column that we find."""
    theirs = _leaves("", scipy.io.loadmat(path, simplify_cells=True))
    wrong = [name for name, values in _read(path).items() if not np.array_equal(theirs.get(name, np.nan), values)]
    return f"{len(wrong)} columns differ" if wrong else ""


def _leaves(name: str, value: Any) -> dict[str, Any]:
    if isinstance(value, dict):
        inner = (_leaves(f"{name}.{key}" if name else key, each) for key, each in value.items())
        return {key: each for found in inner for key, each in found.items()}
    return {name: np.ravel(value)}


def _log(samples: int) -> dict[str, Any]:
    draw = np.random.default_rng(0)
    channels = {f"joint{k}": draw.standard_normal(samples) for k in range(20)}
    return {"t": np.arange(samples) * 1e-3, "q": channels}


def _damaged(folder: Path) -> list[Case]:
    """A small sound file with one bit changed: the caller must survive whatever stands in it."""
    path = folder / "log.mat"
    scipy.io.savemat(path, _log(3), oned_as="column")
    sound = path.read_bytes()
    count = min(FLIPPED, len(sound) - HEADER)
    k, ended = 0, 0
    while k < count:
        k = _survived(path, sound, k, count)
        ended += k < count
        k += 1
    for k in range(count):
        _flip(path, sound, k)
        with contextlib.suppress(InputError):
            _read(path)
    told = f"{ended} of {count} end the interpreter" if ended else ""
    return [Case(f"one bit changed in one of the first {count} bytes", "", told)]


def _flip(path: Path, sound: bytes, k: int) -> None:
    changed = bytearray(sound)
    changed[HEADER + k] ^= 1 << k % 8
    path.write_bytes(changed)


def _survived(path: Path, sound: bytes, first: int, end: int) -> int:
    """The first change from which on a process that calls loadmat does not survive; `end` where it survives all."""
    reader, writer = os.pipe()
    child = os.fork()
    if child == 0:
        os.dup2(os.open(os.devnull, os.O_WRONLY), 2)
        resource.setrlimit(resource.RLIMIT_AS, (MEMORY, MEMORY))  # sizes that are not there are refused at once
        resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
        for k in range(first, end):
            os.write(writer, b".")
            _flip(path, sound, k)
            with contextlib.suppress(Exception):
                scipy.io.loadmat(path)
        os._exit(0)
    os.close(writer)
    with os.fdopen(reader, "rb") as pipe:
        begun = len(pipe.read())
    return first + begun - 1 if os.WIFSIGNALED(os.waitpid(child, 0)[1]) else end
