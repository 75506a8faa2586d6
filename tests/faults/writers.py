"""Everything that flexdyn writes, as pairs of an old and a new content for one place."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import NamedTuple

import numpy as np

import flexdyn as fd
from flexdyn.records import SUFFIXES
from tests.diagnose import report_cases as cases

SAMPLES = 3000


class Writer(NamedTuple):
    """Both take the path; `name` is that of the file, or of the folder of a report."""

    name: str
    old: Callable[[Path], None]
    new: Callable[[Path], None]


def _recording(seed: int) -> fd.Recording:
    values = np.random.default_rng(seed).normal(size=SAMPLES)
    return fd.Recording(np.arange(SAMPLES) * 1e-3, {"q.a": values, "tau.a": values[::-1]})


def _model(name: str) -> Callable[[Path], None]:
    return partial(fd.save_model, fd.load_model(name))


def _some_file(path: Path) -> None:
    path.write_bytes(b"a picture of somebody")


def _motion(name: str) -> fd.Run:
    return fd.simulate(fd.load_model(name), duration=0.02)


def writers() -> dict[str, Writer]:
    """Recordings in every format, a run, a model, pictures, a page of the player, a report; made anew at each call."""
    first, second = _recording(1), _recording(2)
    found = {
        suffix: Writer(f"log{suffix}", partial(fd.write_recording, first), partial(fd.write_recording, second))
        for suffix in SUFFIXES
    }
    run, other = _motion("scara_two_link"), _motion("scara")
    found["run"] = Writer("run.h5", run.save, other.save)
    found["model"] = Writer("model.yaml", _model("scara_two_link"), _model("ur5"))
    for suffix in (".png", ".html"):
        found[f"plot{suffix}"] = Writer(f"plot{suffix}", _some_file, fd.plot(other).save)
    found["report"] = Writer("report", cases.explained().save, cases.no_discrepancy().save)
    return found


def contents(place: Path) -> dict[str, bytes]:
    """Every file at a place, the hidden ones of a folder too."""
    if place.is_file():
        return {place.name: place.read_bytes()}
    return {path.name: path.read_bytes() for path in sorted(place.iterdir())} if place.is_dir() else {}
