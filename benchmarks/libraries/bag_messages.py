"""Messages of ROS: rosbags' own deserialiser against the numbers read out of the bytes of many messages at once.

Both are given the same bag of JointState, open and close it, and end with the same columns.
"""

from __future__ import annotations

import tempfile
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from comparison import Case, Comparison, outcome, times_of
from numpy.typing import NDArray
from rosbags.highlevel import AnyReader

import flexdyn as fd

JOINTS = tuple(f"joint_{k}" for k in range(6))
MESSAGES = 200_000
SIGNALS = {"q": "position", "v": "velocity", "tau": "effort"}
Columns = dict[str, NDArray[np.float64]]


def compare(data: Path) -> Comparison:
    """Both on a bag of ROS 2 and one of ROS 1.

    Args:
        data: folder of the measured data, which holds no bags.
    """
    cases, times = [], {}
    with tempfile.TemporaryDirectory() as folder:
        for suffix in (".mcap", ".bag"):
            path, sent = _written(Path(folder) / f"log{suffix}")
            what = f"{suffix}, {MESSAGES:,} messages of {len(JOINTS)} joints"
            ours, library = partial(_ours, path), partial(_library, path)
            cases.append(Case(what, outcome(partial(_right, ours, sent)), outcome(partial(_right, library, sent))))
            times[what] = times_of(library, ours, 2)
    about = "rosbags, deserialize of every message"
    return Comparison("messages of ROS bags", "flexdyn.records.ros.walk", about, cases, times)


def _written(path: Path) -> tuple[Path, Columns]:
    draw = np.random.default_rng(0)
    sent = {f"{signal}.{joint}": draw.standard_normal(MESSAGES) for signal in SIGNALS for joint in JOINTS}
    fd.write_recording(fd.Recording(np.arange(MESSAGES) * 1e-3, sent), path)
    return path, sent


def _ours(path: Path) -> Columns:
    return dict(fd.read_recording(path).channels)


def _library(path: Path) -> Columns:
    """As rosbags' documentation reads a bag."""
    lists: dict[str, list[Any]] = {signal: [] for signal in SIGNALS}
    names: list[str] = []
    with AnyReader([path]) as reader:
        links = [link for link in reader.connections if link.topic == "/joint_states"]
        for link, _, raw in reader.messages(connections=links):
            message: Any = reader.deserialize(raw, link.msgtype)
            names = names or list(message.name)
            for signal, field in SIGNALS.items():
                lists[signal].append(getattr(message, field))
    tables = {signal: np.array(rows) for signal, rows in lists.items()}
    return {f"{signal}.{joint}": tables[signal][:, k] for signal in SIGNALS for k, joint in enumerate(names)}


def _right(read: Any, sent: Columns) -> bool:
    found = read()
    return set(found) == set(sent) and all(np.array_equal(found[name], sent[name]) for name in sent)
