"""MATLAB files of version 5: `scipy.io.loadmat` against our own reader.

Right on a sound file: the same numbers from both. Right on a damaged one: an error; a process that ends is wrong.
"""

from __future__ import annotations

import os
import tempfile
from pathlib import Path
from typing import Any

import numpy as np
import scipy.io
from comparison import Case, Comparison, times_of

from flexdyn.errors import InputError
from flexdyn.records.matlab import file as mat_file
from flexdyn.records.request import Request

FLIPPED = 500
"""Bytes of the damaged file, of which one bit at a time is changed."""


def compare(data: Path) -> Comparison:
    """Both readers on the measured files that are there, on a large file and on damaged ones.

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
    about = "flexdyn.records.matlab.v5"
    return Comparison("MATLAB files of version 5", about, "SciPy, scipy.io.loadmat", cases, times)


def _times(path: Path) -> float:
    return times_of(lambda: scipy.io.loadmat(path), lambda: _read(path))


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
    """A small sound file with one bit changed: the interpreter must survive whatever stands in it."""
    path = folder / "log.mat"
    scipy.io.savemat(path, _log(3), oned_as="column")
    sound = path.read_bytes()
    ended = {"ours": 0, "library": 0}
    count = min(FLIPPED, len(sound) - 128)
    for k in range(count):
        changed = bytearray(sound)
        changed[128 + k] ^= 1 << k % 8
        path.write_bytes(changed)
        ended["ours"] += _ends(lambda: _read(path))
        ended["library"] += _ends(lambda: scipy.io.loadmat(path))
    told = {name: f"{times} of {count} end the interpreter" if times else "" for name, times in ended.items()}
    return [Case(f"one bit changed in one of the first {count} bytes", told["ours"], told["library"])]


def _ends(work: Any) -> bool:
    """Whether a piece of work ends its process by a signal."""
    child = os.fork()
    if child == 0:
        quiet = os.open(os.devnull, os.O_WRONLY)
        os.dup2(quiet, 2)
        try:
            work()
        except BaseException as error:
            os._exit(2 if isinstance(error, InputError) else 1)
        os._exit(0)
    return os.WIFSIGNALED(os.waitpid(child, 0)[1])
