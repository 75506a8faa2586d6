"""Topics of different times as one recording: which times, what stands between messages, and what is said of it."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from flexdyn.errors import InputError
from flexdyn.records import Recording, RecordingWarning, read_recording
from tests.records.mapping import channel_map
from tests.records.ros_bags import JOINT_STATE, Maker, Message, refused

MS = 1_000_000
START = 5_000_000_000


def position(t: np.ndarray) -> np.ndarray:
    """Of the joint [rad] at times [s]."""
    return np.asarray(np.sin(3.0 * t))


def bag(folder: Path, currents: np.ndarray, positions: np.ndarray | None = None) -> Path:
    """A bag with /joint_states every 4 ms and /motor/currents, 5 t + 1, at the given times [ms]."""
    maker = Maker()
    positions = 4.0 * np.arange(100) if positions is None else positions
    messages: list[Message] = []
    for milliseconds in positions.tolist():
        stamp = START + round(milliseconds * MS)
        state = maker.state(stamp, ["a"], [float(position(np.array(milliseconds / 1e3)))])
        messages.append(("/joint_states", JOINT_STATE, stamp, state))
    kind = "geometry_msgs/msg/Vector3Stamped"
    for milliseconds in currents.tolist():
        stamp = START + round(milliseconds * MS)
        vector = maker.new("geometry_msgs/msg/Vector3", 5.0 * milliseconds / 1e3 + 1.0, 0.0, 0.0)
        messages.append(("/motor/currents", kind, stamp, maker.new(kind, maker.header(stamp), vector)))
    messages.sort(key=lambda message: message[2])
    return maker.write(folder, "mcap", messages)


def merged(path: Path, **source: Any) -> Recording:
    """The two topics by a map, and the warning that it brings."""
    channels = {"q.a": "/joint_states.position.a", "tau.a": "/motor/currents.vector.x"}
    with pytest.warns(RecordingWarning, match="was put on the times of"):
        return read_recording(path, map=channel_map(channels=channels, **({"source": source} if source else {})))


def test_currents_are_put_on_the_times_of_the_joint_states(tmp_path: Path) -> None:
    """On straight lines; outside the currents' own time nothing is made up; how it was done is said and kept."""
    rec = merged(bag(tmp_path, 10.3 + np.arange(300)))
    t = 4e-3 * np.arange(3, 78) + START / 1e9
    np.testing.assert_allclose(rec.t, t, rtol=1e-12)
    np.testing.assert_allclose(rec["q.a"], position(t - START / 1e9), atol=1e-9)
    np.testing.assert_allclose(rec["tau.a"], 5.0 * (t - START / 1e9) + 1.0, rtol=1e-9)
    (said,) = rec.meta["notes"]
    assert said.startswith(
        "/motor/currents (1000 Hz) was put on the times of /joint_states (250 Hz), on straight lines"
    )
    assert "are 0.3 ms from these times in the median, at most 0.3 ms; 75 of 100 samples are common" in said
    assert "source: {topic: ..., merge: ...}" in said


def test_the_map_chooses_the_times_and_what_stands_between(tmp_path: Path) -> None:
    """`topic` names the one whose times hold; `hold` takes the last message."""
    path = bag(tmp_path, 10.3 + np.arange(300))
    held = merged(path, merge="hold")
    np.testing.assert_allclose(held["tau.a"][0], 5.0 * 11.3e-3 + 1.0, rtol=1e-12)
    fast = merged(path, topic="/motor/currents")
    np.testing.assert_allclose(np.diff(fast.t), 1e-3, rtol=1e-9)
    assert len(fast) == 300
    np.testing.assert_array_equal(fast["tau.a"], 5.0 * (10.3 + np.arange(300)) / 1e3 + 1.0)
    with pytest.raises(InputError, match=r"source\.merge: no such choice, got 'spline'"):
        channel_map(source={"merge": "spline"}, others="keep")


def test_where_a_topic_is_silent_nothing_is_made_up(tmp_path: Path) -> None:
    """The joint states of that time are left out, and the gap is told."""
    times = 1.0 * np.arange(400)
    path = bag(tmp_path, times[(times < 100) | (times > 200)])
    channels = {"q.a": "/joint_states.position.a", "tau.a": "/motor/currents.vector.x"}
    with pytest.warns(RecordingWarning) as caught:
        rec = read_recording(path, map=channel_map(channels=channels))
    told = [str(each.message) for each in caught]
    assert any("a gap in the data: 0.108 s from t = 5.096 s on" in text for text in told), told
    np.testing.assert_allclose(rec.gaps, [(5.096, 5.204)], rtol=1e-12)


def test_topics_without_a_common_time(tmp_path: Path) -> None:
    """One ended before the other began; and one whose stamps run backwards."""
    channels = channel_map(channels={"q.a": "/joint_states.position.a", "tau.a": "/motor/currents.vector.x"})
    (tmp_path / "a").mkdir()
    refused(
        bag(tmp_path / "a", 500.0 + np.arange(9)), r"t: /joint_states and /motor/currents have no time", map=channels
    )
    (tmp_path / "b").mkdir()
    maker = Maker()
    kind = "geometry_msgs/msg/PointStamped"
    messages: list[Message] = [
        ("/p", kind, k, maker.new(kind, maker.header(stamp), maker.new("geometry_msgs/msg/Point", 1.0, 2.0, 3.0)))
        for k, stamp in enumerate([10, 30, 20])
    ]
    messages += [("/joint_states", JOINT_STATE, k, maker.state(k, ["a"], [0.0])) for k in range(10, 30)]
    path = maker.write(tmp_path / "b", "mcap", messages)
    chosen = channel_map(channels={"q.a": "/joint_states.position.a", "x": "/p.point.x"})
    with pytest.raises(InputError, match=r"t: message 2 of /p: stamps do not increase; .*clock: bag"):
        read_recording(path, map=chosen)
