"""Bags written by rosbags are read as its own deserialiser reads them, whatever the storage."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from flexdyn.records import Recording, read_recording
from tests.records.mapping import channel_map
from tests.records.ros_bags import JOINT_STATE, KINDS, OLD, Maker, Message, deserialized, refused, states

CONTROLLER = "control_msgs/msg/JointTrajectoryControllerState"
DAY = 1_700_000_000_123_456_789


def columns(messages: list[Any]) -> dict[str, list[float]]:
    """What the deserialised messages hold, by channel: joint by joint, message by message."""
    found: dict[str, list[float]] = {}
    for message in messages:
        for signal, values in (("q", message.position), ("v", message.velocity), ("tau", message.effort)):
            for name, value in zip(message.name, values, strict=True):
                found.setdefault(f"{signal}.{name}", []).append(value)
    return found


@pytest.mark.parametrize("kind", KINDS)
def test_joint_states_as_rosbags_reads_them(tmp_path: Path, kind: str) -> None:
    """Values, names and stamps are those of rosbags' deserialiser, in every storage and compression."""
    maker = Maker(ros1=kind.startswith("bag"))
    path = maker.write(tmp_path, kind, states(maker))
    rec = read_recording(path)
    theirs = deserialized(path, "/joint_states")
    expected = columns(theirs)
    assert {name: values.tolist() for name, values in rec.channels.items()} == expected
    stamps = [10**9 * each.header.stamp.sec + each.header.stamp.nanosec for each in theirs]
    assert rec.t.tolist() == [stamp / 10**9 for stamp in stamps]
    assert rec.name == "log"
    assert rec.meta["notes"] == (
        "effort of /joint_states was taken as tau, the commanded torque; map it to tau_s if it is measured",
    )


def test_several_blocks_and_progress(tmp_path: Path) -> None:
    """Many messages are read in blocks; the progress grows to the end."""
    maker = Maker()
    path = maker.write(tmp_path, "mcap", states(maker, 9000))
    shares: list[float] = []
    rec = read_recording(path, progress=shares.append)
    assert {name: values.tolist() for name, values in rec.channels.items()} == columns(
        deserialized(path, "/joint_states")
    )
    assert len(shares) == 2
    assert shares == sorted(shares)
    assert shares[-1] == 8192 / 9000


def test_big_endian_messages(tmp_path: Path) -> None:
    """CDR comes in either byte order; both are read, even mixed."""
    maker = Maker()
    messages = states(maker, 6)
    mixed = [
        (topic, kind, time, maker.raw(kind, message, little=row % 2 == 0))
        for row, (topic, kind, time, message) in enumerate(messages)
    ]
    rec = read_recording(maker.write(tmp_path, "mcap", mixed))
    assert {name: values.tolist() for name, values in rec.channels.items()} == columns([each[3] for each in messages])


@pytest.mark.parametrize("ros1", [False, True])
def test_controller_states(tmp_path: Path, ros1: bool) -> None:
    """Feedback (older: actual) is the motion, output the torque; what was asked of the joints is left to a map."""
    maker = Maker(ros1=ros1, texts=OLD if ros1 else None)
    some, none = [(1.0, 2.0), (3.0, 4.0), (5.0, 6.0)], maker.point()
    motion, torque = maker.point(some[0], some[1]), maker.point(effort=some[2])
    multi = (
        []
        if ros1
        else [
            [],
            *[maker.new("trajectory_msgs/msg/MultiDOFJointTrajectoryPoint", [], [], [], none.time_from_start)] * 4,
            1.0,
        ]
    )
    points = [torque, motion, none] if ros1 else [none, motion, none, torque]
    messages: list[Message] = [
        ("/arm/state", CONTROLLER, stamp, maker.new(CONTROLLER, maker.header(stamp), ["a", "b"], *points, *multi))
        for stamp in (10, 20)
    ]
    rec = read_recording(maker.write(tmp_path, "bag" if ros1 else "mcap", messages))
    expected = {"q.a": 1.0, "q.b": 2.0, "v.a": 3.0, "v.b": 4.0} | ({} if ros1 else {"tau.a": 5.0, "tau.b": 6.0})
    assert {name: values.tolist() for name, values in rec.channels.items()} == {k: [v, v] for k, v in expected.items()}
    assert rec.t.tolist() == [1e-8, 2e-8]


def test_a_bag_without_definitions(tmp_path: Path) -> None:
    """Bags of older ROS 2 do not say what their messages are: the versions of the controller's state are told apart."""
    import sqlite3

    for texts in (OLD, None):
        maker = Maker(texts=texts)
        none = maker.point()
        motion = maker.point([1.5], [2.5])
        multi = [maker.new("trajectory_msgs/msg/MultiDOFJointTrajectoryPoint", [], [], [], none.time_from_start)] * 4
        rest = [none, motion, none] if texts else [none, motion, none, none, [], *multi, 0.5]
        messages: list[Message] = [
            ("/state", CONTROLLER, stamp, maker.new(CONTROLLER, maker.header(stamp, "frame"), ["a"], *rest))
            for stamp in (1, 2, 3)
        ]
        folder = tmp_path / str(bool(texts))
        folder.mkdir()
        path = maker.write(folder, "db3", messages)
        with sqlite3.connect(path) as base:
            base.executescript("UPDATE schema SET schema_version = 3; DROP TABLE message_definitions;")
        base.close()
        rec = read_recording(path)
        assert {name: values.tolist() for name, values in rec.channels.items()} == {"q.a": [1.5] * 3, "v.a": [2.5] * 3}


def test_dynamic_joint_states(tmp_path: Path) -> None:
    """Interfaces position, velocity and effort of each joint; others are columns for a map."""
    maker = Maker()
    value = "control_msgs/msg/InterfaceValue"
    messages: list[Message] = []
    for stamp in (1000, 2000):
        parts = [
            maker.new(value, ["velocity", "position"], np.array([1.0, 2.0])),
            maker.new(value, ["position", "temperature"], np.array([3.0, 40.0 + stamp])),
        ]
        whole = maker.new("control_msgs/msg/DynamicJointState", maker.header(stamp), ["a", "b"], parts)
        messages.append(("/dynamic_joint_states", "control_msgs/msg/DynamicJointState", stamp, whole))
    path = maker.write(tmp_path, "mcap", messages)
    rec = read_recording(path)
    assert {name: values.tolist() for name, values in rec.channels.items()} == {
        "q.a": [2, 2],
        "q.b": [3, 3],
        "v.a": [1, 1],
    }
    rec = read_recording(path, map=channel_map(channels={"temperature.b": "temperature.b", "q.b": "position.b"}))
    assert rec["temperature.b"].tolist() == [1040.0, 2040.0]


def test_times_of_day_are_counted_from_the_first(tmp_path: Path) -> None:
    """No double holds nanoseconds since 1970; the difference of whole numbers loses nothing."""
    maker = Maker()
    stamps = [DAY, DAY + 1, DAY + 3_000_000_007]
    path = maker.write(tmp_path, "mcap", [("/s", JOINT_STATE, 5, maker.state(stamp, ["a"], [1.0])) for stamp in stamps])
    rec = read_recording(path)
    assert rec.t.tolist() == [0.0, 1e-9, 3.000000007]
    assert rec.meta["start_ns"] == DAY


def test_the_clock_of_the_bag(tmp_path: Path) -> None:
    """Without stamps, the time of recording is taken when that is asked for."""
    maker = Maker()
    path = maker.write(
        tmp_path,
        "bag" if maker.ros1 else "mcap",
        [("/s", JOINT_STATE, row, maker.state(0, ["a"], [row])) for row in range(1, 4)],
    )
    refused(path, "/s: every stamp is zero; take the time of recording: source: {clock: bag}")
    rec = read_recording(path, map=channel_map(source={"clock": "bag"}, others="keep"))
    assert rec.t.tolist() == [1e-9, 2e-9, 3e-9]


@pytest.mark.parametrize(
    ("stamps", "words"),
    [((5, 9, 9), "message 2: two samples at one time"), ((5, 9, 7), "message 2: time runs backwards")],
)
def test_times_that_do_not_grow(tmp_path: Path, stamps: tuple[int, ...], words: str) -> None:
    """The line names the message; nothing is repaired in silence."""
    maker = Maker()
    messages: list[Message] = [
        ("/s", JOINT_STATE, row, maker.state(stamp, ["a"], [1.0])) for row, stamp in enumerate(stamps)
    ]
    refused(maker.write(tmp_path, "mcap", messages), f"t: {words}")


def test_what_was_never_measured_is_left_out(tmp_path: Path) -> None:
    """NaN throughout stands for what a drive does not measure: left out and noted. A gap is an error."""
    maker = Maker()
    nan = float("nan")
    messages: list[Message] = [("/s", JOINT_STATE, row, maker.state(row, ["a"], [row], [nan], [])) for row in (1, 2)]
    path = maker.write(tmp_path, "mcap", messages)
    rec = read_recording(path)
    assert set(rec.channels) == {"q.a"}
    assert rec.meta["notes"] == ("v.a of /s is NaN in every message and was left out",)
    path.unlink()
    messages.append(("/s", JOINT_STATE, 3, maker.state(3, ["a"], [3], [0.0], [])))
    refused(maker.write(tmp_path, "mcap", messages), "v.a: message 0: not a finite number")


def test_split_bags_are_one(tmp_path: Path) -> None:
    """A folder may hold several files in order."""
    maker = Maker()
    whole = states(maker, 10)
    for number, part in enumerate((whole[:4], whole[4:])):
        (tmp_path / str(number)).mkdir()
        maker.write(tmp_path / str(number), "mcap", part)
    bag = maker.write(tmp_path, "folder mcap", whole)
    for number in (0, 1):
        (tmp_path / str(number) / "log.mcap").rename(bag / f"log_{number}.mcap")
    text = (bag / "metadata.yaml").read_text()
    (bag / "metadata.yaml").write_text(
        text.replace(
            "  relative_file_paths:\n  - log.mcap", "  relative_file_paths:\n  - log/log_0.mcap\n  - log_1.mcap"
        )
    )
    rec = read_recording(bag)
    assert isinstance(rec, Recording)
    assert {name: values.tolist() for name, values in rec.channels.items()} == columns([each[3] for each in whole])
