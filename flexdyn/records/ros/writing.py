"""A recording as a bag: JointState for the standard signals, DynamicJointState for everything else."""

from __future__ import annotations

import os
import sqlite3
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
from rosbags import rosbag1, rosbag2
from rosbags.typesys import Stores, get_typestore

from flexdyn.errors import InputError
from flexdyn.records.meta import as_json, as_plain
from flexdyn.records.recording import Recording
from flexdyn.records.ros.clock import NANO, Integers, nanoseconds, seconds
from flexdyn.records.ros.columns import (
    CHANNELS_TOPIC,
    DYNAMIC_JOINT_STATE,
    FIELDS,
    JOINT_STATE,
    OWN_TOPICS,
    message_columns,
    stamp_of,
)
from flexdyn.records.ros.definitions import control_types
from flexdyn.records.ros.reading import META_TOPIC, TEXT_MESSAGE
from flexdyn.records.ros.walk import Bytes, lay_out
from flexdyn.records.units import split_name

_LATEST = 2**31 * NANO
_BAG_BLOCK = 4096


@dataclass(frozen=True)
class Group:
    """Channels of one topic: joints with the channels of their position, velocity and effort."""

    topic: str
    msgtype: str
    channels: dict[str, str]


def write_bag(rec: Recording, path: Path, suffix: str) -> None:
    """Write a bag; see the package's docstring.

    Args:
        rec: the recording.
        path: of the new file.
        suffix: ``.bag``, ``.mcap`` or ``.db3``.
    """
    stamps, zero = _stamps(rec)
    channels = list(rec.channels)
    note = as_json({"zero_ns": zero, "channels": channels, "meta": as_plain(rec.meta)})
    cdr = suffix != ".bag"
    store = _store(cdr)
    serialize: Callable[[Any, str], memoryview] = store.serialize_cdr if cdr else store.serialize_ros1
    exact = np.array_equal(seconds(stamps, zero).view(np.int64), rec.t.view(np.int64))
    groups = list(_groups(channels if exact else [*channels, "t"]))
    with TemporaryDirectory(dir=path.parent, prefix=".") as folder:
        bag = Path(folder) / "bag"
        with _refusals_as_usual(), _writer(bag, suffix) as writer:
            text = writer.add_connection(META_TOPIC, TEXT_MESSAGE, typestore=store)
            links = [writer.add_connection(group.topic, group.msgtype, typestore=store) for group in groups]
            writer.write(text, int(stamps[0]), serialize(store.types[TEXT_MESSAGE](note), TEXT_MESSAGE))
            first = [bytes(serialize(_message(store, group, cdr), group.msgtype)) for group in groups]
            for begin in range(0, len(stamps), _BAG_BLOCK):
                some = slice(begin, begin + _BAG_BLOCK)
                blocks = [_block(rec, g, raw, stamps[some], some, store) for g, raw in zip(groups, first, strict=True)]
                for row, stamp in enumerate(stamps[some].tolist()):
                    for link, block in zip(links, blocks, strict=True):
                        writer.write(link, stamp, block[row].tobytes())
        os.replace(bag / f"bag{suffix}" if cdr else bag, path)


@contextmanager
def _refusals_as_usual() -> Iterator[None]:
    """Raise OSError for a full disk with SQLite too, which stores the messages of a .db3 bag."""
    try:
        yield
    except sqlite3.Error as error:
        raise OSError(str(error)) from None


@cache
def _store(cdr: bool) -> Any:
    """Message types of ROS 2 or 1, with control_msgs."""
    store = get_typestore(Stores.ROS2_HUMBLE if cdr else Stores.ROS1_NOETIC)
    store.register(control_types())
    return store


def _writer(path: Path, suffix: str) -> Any:
    if suffix == ".bag":
        return rosbag1.Writer(path)
    plugin = rosbag2.StoragePlugin.MCAP if suffix == ".mcap" else rosbag2.StoragePlugin.SQLITE3
    return rosbag2.Writer(path, version=9, storage_plugin=plugin)


def _stamps(rec: Recording) -> tuple[Integers, int]:
    """Stamps [ns], never negative, and the stamp that is time 0."""
    value, remedy = float(rec.t[-1]), "count from the start"
    too_late = InputError("ROS cannot hold the time", key="t", value=value, remedy=remedy)
    if max(-float(rec.t[0]), value) >= _LATEST / NANO:
        raise too_late
    since = nanoseconds(rec.t)
    same = since[1:] == since[:-1]
    if same.any():
        row = int(np.argmax(same)) + 1
        problem = f"row {row}: two samples fall on one nanosecond, which is all that ROS resolves"
        raise InputError(problem, value=float(rec.t[row]), remedy="write another format", row=row, channel="t")
    first, last = int(since[0]), int(since[-1])
    start = rec.meta.get("start_ns", 0)
    fits = isinstance(start, int) and not isinstance(start, bool)
    if not fits or start + first < 0 or start + last >= _LATEST:
        start = max(0, -first)
    if start + last >= _LATEST:
        raise too_late
    return since + start, start


def _groups(channels: list[str]) -> Iterator[Group]:
    """Every channel in one topic; joints that have the same fields share one."""
    left = dict.fromkeys(channels)
    for topic, signals in OWN_TOPICS.items():
        fields = dict(zip(signals, FIELDS, strict=True))
        joints: dict[str, list[str]] = {}
        for channel in channels:
            parts = split_name(channel)
            if parts and parts[0] and parts[0] in fields:
                joints.setdefault(parts[1], []).append(parts[0])
        kinds: dict[frozenset[str], list[str]] = {}
        for joint, present in joints.items():
            kinds.setdefault(frozenset(present), []).append(joint)
        for number, (kind, names) in enumerate(kinds.items()):
            columns = {f"{fields[s]}.{joint}": f"{s}.{joint}" for s in signals if s in kind for joint in names}
            label = "_".join(fields[signal] for signal in signals if signal in kind)
            yield Group(f"/{topic}/{label}" if number else f"/{topic}", JOINT_STATE, columns)
            for channel in columns.values():
                del left[channel]
    if left:
        yield Group(CHANNELS_TOPIC, DYNAMIC_JOINT_STATE, {channel: channel for channel in left})


def _message(store: Any, group: Group, cdr: bool) -> Any:
    """One message with names and zeros, to be filled."""
    types = store.types
    stamp = types["builtin_interfaces/msg/Time"](0, 0)
    header = types["std_msgs/msg/Header"](*(() if cdr else (0,)), stamp, "")
    if group.msgtype == DYNAMIC_JOINT_STATE:
        value = types["control_msgs/msg/InterfaceValue"]
        parts = [channel.partition(".") for channel in group.channels]
        values = [value([interface], np.zeros(1)) for interface, _, _ in parts]
        return types[DYNAMIC_JOINT_STATE](header, [joint for _, _, joint in parts], values)
    pairs = [column.partition(".") for column in group.channels]
    names = list(dict.fromkeys(joint for _, _, joint in pairs))
    present = {field for field, _, _ in pairs}
    return types[JOINT_STATE](header, names, *(np.zeros(len(names) if field in present else 0) for field in FIELDS))


def _block(rec: Recording, group: Group, raw: bytes, stamps: Integers, some: slice, store: Any) -> Bytes:
    """The messages of some rows, as bytes (rows, length)."""
    fields = {name: parsed[1] for name, parsed in store.fielddefs.items()}
    layout = lay_out(raw, group.msgtype, fields, cdr="seq" not in dict(fields["std_msgs/msg/Header"]))
    block = np.tile(np.frombuffer(raw, np.uint8), (len(stamps), 1))
    seconds, nanos = stamp_of(layout) or (None, None)
    if seconds is not None and nanos is not None:
        seconds.put(block, stamps // NANO)
        nanos.put(block, stamps % NANO)
    numbers = message_columns(layout, group.msgtype)
    for column, channel in group.channels.items():
        numbers[column].put(block, (rec.t if channel == "t" else rec[channel])[some])
    return block
