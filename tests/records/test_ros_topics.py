"""Topics, joints and columns: what is chosen, what a map chooses, and what does not go together."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from flexdyn.errors import InputError
from flexdyn.records import read_recording
from flexdyn.records.request import Layout, Request
from flexdyn.records.ros import read
from tests.records.mapping import channel_map
from tests.records.ros_bags import JOINT_STATE, NAMES, Maker, Message, refused, states


def raw(path: Path, *names: str, topic: str | None = None, clock: str = "message") -> dict[str, list[float]]:
    """The raw columns that a channel map would ask for."""
    table = read(path, Request(frozenset(names), Layout(topic=topic, clock=clock)))
    return {name: values.tolist() for name, values in table.columns.items()}


def measurements(maker: Maker) -> list[Message]:
    """Three messages on each of four topics, of which two have no header."""
    vector, layout = "geometry_msgs/msg/Vector3", "std_msgs/msg/MultiArrayLayout"
    messages: list[Message] = []
    for row in range(3):
        time = 10 * row + 1
        torque = maker.new(vector, 4.0, 5.0, 6.0)
        wrench = maker.new("geometry_msgs/msg/Wrench", maker.new(vector, row, 2.0, 3.0), torque)
        blob = np.arange(row, dtype=np.uint8)
        drive = (True, 0.1 * row, np.array([row, -2], np.int16), blob, "x" * row, 2**40 + row)
        side = maker.new(layout, [maker.new("std_msgs/msg/MultiArrayDimension", "d", 2, 2)], 0)
        for topic, kind, values in (
            ("/ft", "geometry_msgs/msg/WrenchStamped", (maker.header(time), wrench)),
            ("/drive", "lab_msgs/msg/Drive", (maker.header(time), *drive)),
            ("/list", "std_msgs/msg/Float64MultiArray", (side, np.array([1.0, row]))),
            ("/one", "std_msgs/msg/Float64", (2.5 * row,)),
        ):
            messages.append((topic, kind, time, maker.new(kind, *values)))
    return messages


@pytest.mark.parametrize("kind", ["bag", "mcap"])
def test_raw_columns_of_any_message(tmp_path: Path, kind: str) -> None:
    """Fields by their path; numbers of every size at their own alignment; lists of bytes and texts are passed over."""
    maker = Maker(ros1=kind == "bag")
    path = maker.write(tmp_path, kind, measurements(maker))
    t = [1e-9, 1.1e-8, 2.1e-8]
    assert raw(path, "wrench.force.x", "wrench.torque.z", "t", topic="/ft") == {
        "t": t,
        "wrench.force.x": [0.0, 1.0, 2.0],
        "wrench.torque.z": [6.0] * 3,
    }
    several = raw(path, "/drive.counts.0", "/drive.counts.1", "/drive.current", "/drive.ticks", "/ft.wrench.force.y")
    assert several.pop("/drive.current") == [float(np.float32(0.1 * row)) for row in range(3)]
    assert several == {
        "t": t,
        "/drive.counts.0": [0.0, 1.0, 2.0],
        "/drive.counts.1": [-2.0] * 3,
        "/drive.ticks": [2.0**40 + row for row in range(3)],
        "/ft.wrench.force.y": [2.0] * 3,
    }
    assert raw(path, "/list.data.1", "/one.data", clock="bag") == {
        "t": t,
        "/list.data.1": [0.0, 1.0, 2.0],
        "/one.data": [0.0, 2.5, 5.0],
    }
    with pytest.raises(InputError, match=r"/one: messages of std_msgs/msg/Float64 have no stamp; .*clock: bag"):
        raw(path, "data", topic="/one")
    with pytest.raises(
        InputError, match=r"wrench.force.w: the topic /ft has no such column; did you mean 'wrench.force"
    ):
        raw(path, "wrench.force.w", topic="/ft")
    with pytest.raises(InputError, match=r"several topics could be read; .*/ft, /drive, /list, /one"):
        raw(path, "wrench.force.x")
    refused(path, "no topic of joint states; .*/ft .geometry_msgs/msg/WrenchStamped")


def test_topics_are_chosen_by_a_map(tmp_path: Path) -> None:
    """Two topics of joint states: the line lists them, and a map chooses by convention or by column."""
    maker = Maker()
    path = maker.write(tmp_path, "folder mcap", [*states(maker, topic="/left"), *states(maker, topic="/right")])
    refused(path, r"several topics could be read; choose one .*source: \{topic: .*; there are /left, /right$")
    refused(
        path, r"such as \{flexdyn_map: 1, channels: \{q.JOINT: /left.position.JOINT, tau.JOINT: /right.effort.JOINT"
    )
    left = read_recording(path, map=channel_map(source={"topic": "/left"}, others="keep"))
    assert set(left.channels) == {f"{signal}.{name}" for signal in ("q", "v", "tau") for name in NAMES}
    both = read_recording(
        path, map=channel_map(channels={"q.l": "/left.position.elbow", "q.r": "/right.position.elbow"})
    )
    assert both["q.l"].tolist() == both["q.r"].tolist() == left["q.elbow"].tolist()
    refused(
        path, "/lefd: the bag has no such topic; did you mean '/left'", map=channel_map(channels={"q.l": "/lefd.x"})
    )


def test_two_publishers_on_one_topic(tmp_path: Path) -> None:
    """Arm and gripper take turns on /joint_states: refused as one recording, read one group at a time."""
    maker = Maker()
    messages: list[Message] = []
    for row in range(6):
        names = ("a", "b") if row % 2 == 0 else ("gripper",)
        messages.append(("/joint_states", JOINT_STATE, row, maker.state(row, names, [float(row)] * len(names))))
    path = maker.write(tmp_path, "mcap", messages)
    refused(
        path,
        "/joint_states: message 1 lacks position.a, position.b, which the first has; several publishers",
    )
    assert raw(path, "position.gripper") == {"t": [1e-9, 3e-9, 5e-9], "position.gripper": [1.0, 3.0, 5.0]}
    assert raw(path, "position.b", "position.a")["t"] == [0.0, 2e-9, 4e-9]
    with pytest.raises(InputError, match=r"position.c: .* no such column; did you mean 'position"):
        raw(path, "position.c")
    with pytest.raises(
        InputError,
        match=r"position.gripper: message 0 of /joint_states has no such column, but.*several publishers share",
    ):
        raw(path, "position.a", "position.gripper")


def test_joints_that_come_or_go(tmp_path: Path) -> None:
    """A message with a joint more, or without velocities, is named."""
    maker = Maker()
    for number, other in enumerate(
        [
            maker.state(2, ["a", "b"], [1.0, 2.0], [0.0, 0.0]),
            maker.state(2, ["a"], [1.0]),
            maker.state(2, ["a"], [1.0, 2.0]),
        ]
    ):
        folder = tmp_path / str(number)
        folder.mkdir()
        first = ("/s", JOINT_STATE, 1, maker.state(1, ["a"], [1.0], [0.0]))
        path = maker.write(folder, "db3", [first, ("/s", JOINT_STATE, 2, other)])
        words = (
            "message 1 has position.b, velocity.b, which the first lacks",
            "message 1 lacks velocity.a",
            "position: 2 numbers for 1 joints",
        )
        refused(path, words[number])
