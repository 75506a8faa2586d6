"""Bags for the tests, written by rosbags alone, and read by its own deserialiser for comparison."""

from __future__ import annotations

import shutil
from collections.abc import Sequence
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from rosbags import rosbag1, rosbag2
from rosbags.highlevel import AnyReader
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

from flexdyn.errors import InputError
from flexdyn.records import read_recording

KINDS = (
    "bag",
    "bag bz2",
    "bag lz4",
    "mcap",
    "mcap zstd",
    "db3",
    "folder mcap",
    "folder db3",
    "files zstd",
    "each zstd",
)

POINT = "trajectory_msgs/JointTrajectoryPoint"
TEXTS = {
    "control_msgs/msg/JointTrajectoryControllerState": "std_msgs/Header header\nstring[] joint_names\n"
    f"{POINT} reference\n{POINT} feedback\n{POINT} error\n{POINT} output\nstring[] multi_dof_joint_names\n"
    + "".join(f"trajectory_msgs/MultiDOFJointTrajectoryPoint multi_dof_{x}\n" for x in ("reference", "feedback"))
    + "".join(f"trajectory_msgs/MultiDOFJointTrajectoryPoint multi_dof_{x}\n" for x in ("error", "output"))
    + "float64 speed_scaling_factor\n",
    "control_msgs/msg/InterfaceValue": "string[] interface_names\nfloat64[] values\n",
    "control_msgs/msg/DynamicJointState": "std_msgs/Header header\nstring[] joint_names\n"
    "control_msgs/InterfaceValue[] interface_values\n",
    "lab_msgs/msg/Drive": "std_msgs/Header header\nbool on\nfloat32 current\nint16[2] counts\nuint8[] blob\n"
    "string label\nuint64 ticks\n",
}
OLD = {
    "control_msgs/msg/JointTrajectoryControllerState": "std_msgs/Header header\nstring[] joint_names\n"
    f"{POINT} desired\n{POINT} actual\n{POINT} error\n"
}
NAMES = ("shoulder", "elbow", "wrist roll")
JOINT_STATE = "sensor_msgs/msg/JointState"
Message = tuple[str, str, int, Any]
"""Topic, type, time of recording [ns], message."""


@cache
def _store(ros1: bool, texts: tuple[tuple[str, str], ...]) -> Any:
    store = get_typestore(Stores.ROS1_NOETIC if ros1 else Stores.ROS2_HUMBLE)
    for name, text in texts:
        store.register(get_types_from_msg(text, name))
    return store


class Maker:
    """Makes messages and bags of one version of ROS; `texts` define the types that rosbags does not bring."""

    def __init__(self, *, ros1: bool = False, texts: dict[str, str] | None = None) -> None:
        self.ros1 = ros1
        self.store = _store(ros1, tuple((TEXTS if texts is None else texts).items()))

    def new(self, msgtype: str, *values: Any) -> Any:
        """A message of any type."""
        return self.store.types[msgtype](*values)

    def header(self, stamp: int, frame: str = "") -> Any:
        """A header with a stamp [ns]."""
        time = self.new("builtin_interfaces/msg/Time", stamp // 10**9, stamp % 10**9)
        return self.new("std_msgs/msg/Header", *((7,) if self.ros1 else ()), time, frame)

    def state(self, stamp: int, names: Sequence[str], *lists: Sequence[float], frame: str = "") -> Any:
        """A JointState; lists that are left out are empty."""
        arrays = [np.array(values, float) for values in (*lists, *([],) * (3 - len(lists)))]
        return self.new(JOINT_STATE, self.header(stamp, frame), list(names), *arrays)

    def point(
        self, positions: Sequence[float] = (), velocities: Sequence[float] = (), effort: Sequence[float] = ()
    ) -> Any:
        """A point of a trajectory."""
        lists = [np.array(values, float) for values in (positions, velocities, (), effort)]
        return self.new(
            "trajectory_msgs/msg/JointTrajectoryPoint", *lists, self.new("builtin_interfaces/msg/Duration", 0, 0)
        )

    def raw(self, msgtype: str, message: Any, *, little: bool = True) -> bytes:
        """A message as bytes."""
        if isinstance(message, bytes):
            return message
        if self.ros1:
            return bytes(self.store.serialize_ros1(message, msgtype))
        return bytes(self.store.serialize_cdr(message, msgtype, little_endian=little))

    def write(self, folder: Path, kind: str, messages: Sequence[Message]) -> Path:
        """A bag of one of `KINDS`, named log."""
        where, _, how = kind.partition(" ")
        bag = folder / ("log.bag" if where == "bag" else "log")
        with self._writer(bag, where, how) as writer:
            links: dict[tuple[str, str], Any] = {}
            for topic, msgtype, time, message in messages:
                if (topic, msgtype) not in links:
                    links[topic, msgtype] = writer.add_connection(topic, msgtype, typestore=self.store)
                writer.write(links[topic, msgtype], time, self.raw(msgtype, message))
        if where in ("mcap", "db3"):
            shutil.move(bag / f"log.{where}", folder / f"log.{where}")
            shutil.rmtree(bag)
            return folder / f"log.{where}"
        return bag

    def _writer(self, bag: Path, where: str, how: str) -> Any:
        if where == "bag":
            writer = rosbag1.Writer(bag)
            if how:
                writer.set_compression(writer.CompressionFormat[how.upper()])
            return writer
        plugin = rosbag2.StoragePlugin.MCAP if "mcap" in (where, how) else rosbag2.StoragePlugin.SQLITE3
        packed = rosbag2.Writer(bag, version=9, storage_plugin=plugin)
        mode = {"mcap zstd": "STORAGE", "files zstd": "FILE", "each zstd": "MESSAGE"}.get(f"{where} {how}", "NONE")
        packed.set_compression(rosbag2.CompressionMode[mode], rosbag2.CompressionFormat.ZSTD)
        return packed


def deserialized(path: Path, topic: str) -> list[Any]:
    """All messages of a topic by rosbags' own reader and deserialiser."""
    with AnyReader([path]) as reader:
        links = [link for link in reader.connections if link.topic == topic]
        return [reader.deserialize(raw, link.msgtype) for link, _, raw in reader.messages(links)]


def states(maker: Maker, count: int = 40, topic: str = "/joint_states", start: int = 5_000_000) -> list[Message]:
    """Joint states at odd times, of which every third has another order of joints and another frame."""
    rng = np.random.default_rng(3)
    messages: list[Message] = []
    for row in range(count):
        stamp = start + 1_000_003 * row
        order = rng.permutation(3) if row % 3 == 2 else np.arange(3)
        lists = rng.standard_normal((3, 3))
        frame = "base" if row % 3 else "base_link"
        message = maker.state(stamp, [NAMES[index] for index in order], *lists, frame=frame)
        messages.append((topic, JOINT_STATE, stamp + 77, message))
    return messages


def refused(path: Path, words: str = ".", **options: Any) -> None:
    """The bag is refused in one line that begins with its path."""
    with pytest.raises(InputError, match=words) as caught:
        read_recording(path, **options)
    assert str(caught.value).startswith(str(path))
    assert str(caught.value).isprintable()
    assert len(str(caught.value)) < 700 + len(str(path))
