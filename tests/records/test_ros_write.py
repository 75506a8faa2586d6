"""Bags written by flexdyn: every double comes back, and others read them too."""

from __future__ import annotations

import sqlite3
import sys
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from flexdyn.errors import InputError, MissingExtra
from flexdyn.records import Recording, read_recording, write_recording
from tests.records.mapping import channel_map
from tests.records.ros_bags import deserialized

KINDS = (".bag", ".mcap", ".db3")
NAMES = st.text(
    st.characters(codec="utf-8", exclude_categories=("C", "Z"), include_characters=" "), min_size=1, max_size=8
).filter(
    lambda name: name.isprintable() and name == name.strip() and name[-1] != "." and "," not in name and name != "t"
)
NAMES |= st.builds("{}.{}".format, st.sampled_from(["q", "v", "tau", "theta", "tau_s", "x"]), NAMES)
NANOSECONDS = np.array([0, 1, 3, 10**9 + 1, 7 * 10**15 + 3])
"""Up to 81 days: beyond 2^53 of them whole nanoseconds are no doubles themselves."""


def recording(t: np.ndarray, meta: dict[str, object] | None = None) -> Recording:
    """Every signal, joints that have some of them only, channels of no joint, awkward numbers and names."""
    rng = np.random.default_rng(5)
    names = [f"{signal}.{joint}" for joint in ("a", "b") for signal in ("q", "v", "tau", "theta", "omega")]
    names += ["tau.c", "q.d", "tau_s.b", "tau_applied.a", "temperature.b", "power", "gripper.force.x", "q.e f/ü"]
    channels = {name: rng.standard_normal(len(t)) for name in names}
    channels["v.b"][:3] = (-0.0, 5e-324, 1.7976931348623157e308)
    return Recording(t, channels, meta=meta)


@pytest.mark.parametrize("suffix", KINDS)
def test_a_round_trip_is_bit_for_bit(tmp_path: Path, suffix: str) -> None:
    """Samples, times on whole nanoseconds, order of channels and meta."""
    path = tmp_path / f"log{suffix}"
    for stamps in (NANOSECONDS, NANOSECONDS - 5, 16 * NANOSECONDS[:4] + 30 * 10**15):
        rec = recording(np.array([stamp / 10**9 for stamp in stamps.tolist()]), {"units": {"q.d": "m"}, "k": [1, None]})
        write_recording(rec, path)
        assert read_recording(path) == rec
    assert [each.name for each in tmp_path.iterdir()] == [path.name]


@pytest.mark.parametrize("suffix", KINDS)
def test_more_than_a_block(tmp_path: Path, suffix: str) -> None:
    """Messages are made in blocks; times need not be whole nanoseconds."""
    t = np.arange(5000) * 1e-3
    rec = Recording(t, {"q.a": np.sin(t), "tau.a": np.cos(t), "power": t})
    write_recording(rec, tmp_path / f"log{suffix}")
    assert read_recording(tmp_path / f"log{suffix}") == rec


@settings(max_examples=30, deadline=None)
@given(
    stamps=st.lists(st.integers(-(2**56), 2**60), min_size=2, max_size=6, unique=True).map(sorted),
    value=st.floats(allow_nan=False, allow_infinity=False),
)
def test_any_whole_nanosecond(tmp_path_factory: pytest.TempPathFactory, stamps: list[int], value: float) -> None:
    """Times that are the doubles nearest to whole nanoseconds come back, if they differ."""
    t = np.array([stamp / 10**9 for stamp in stamps])
    if not (np.diff(t) > 0).all() or [round(time * 1e9) for time in t] != stamps:
        return
    path = tmp_path_factory.mktemp("any") / "log.mcap"
    rec = Recording(t, {"q.a": np.full(len(t), value)})
    write_recording(rec, path)
    assert read_recording(path) == rec


@pytest.mark.parametrize("suffix", KINDS)
def test_others_read_joint_states(tmp_path: Path, suffix: str) -> None:
    """The reader of rosbags finds JointState by the definitions that the bag carries."""
    t = np.array([0.5, 1.25])
    channels = {"q.a": t, "q.b": 2 * t, "tau.a": 3 * t, "tau.b": 4 * t, "theta.b": 5 * t, "tau_s.a": 6 * t, "q.c": t}
    path = tmp_path / f"log{suffix}"
    write_recording(Recording(t, {**channels, "temperature.a": 7 * t}), path)
    last = deserialized(path, "/joint_states")[-1]
    assert (last.name, last.position.tolist(), last.velocity.tolist()) == (["a", "b"], [1.25, 2.5], [])
    assert last.effort.tolist() == [3.75, 5.0]
    assert (last.header.stamp.sec, last.header.stamp.nanosec) == (1, 250_000_000)
    assert deserialized(path, "/joint_states/position")[0].name == ["c"]
    assert deserialized(path, "/motor_states")[0].position.tolist() == [2.5]
    assert deserialized(path, "/transmission_states")[0].effort.tolist() == [3.0]
    other = deserialized(path, "/flexdyn/channels")[0]
    assert (other.joint_names, other.interface_values[0].interface_names) == (["a"], ["temperature"])
    rec = read_recording(path, map=channel_map(channels={"tau_s.b": "/joint_states.effort.b"}))
    assert rec["tau_s.b"].tolist() == [2.0, 5.0]


@pytest.mark.parametrize("suffix", KINDS)
def test_some_channels_of_a_bag_of_ours(tmp_path: Path, suffix: str) -> None:
    """A map names channels as they were written; a topic brings its own columns."""
    t = np.array([0.5, 1.25])
    path = tmp_path / f"log{suffix}"
    write_recording(Recording(t, {"q.a": t, "theta.a": 2 * t}), path)
    assert read_recording(path, map=channel_map(channels={"q.b": "theta.a"}))["q.b"].tolist() == [1.0, 2.5]
    rec = read_recording(path, map=channel_map(source={"topic": "/motor_states"}, channels={"q.b": "position.a"}))
    assert rec["q.b"].tolist() == [1.0, 2.5]
    with pytest.raises(InputError, match=r"q\.z"):
        read_recording(path, map=channel_map(channels={"q.b": "q.z"}))


def test_the_time_of_day_comes_back(tmp_path: Path) -> None:
    """start_ns puts the stamps where they were; t stays as it is, also where the start was cut off."""
    start = 1_700_000_000_123_456_789
    rec = Recording([2.0, 3.5], {"q.a": [1.0, 2.0]}, meta={"start_ns": start})
    write_recording(rec, tmp_path / "log.mcap")
    assert read_recording(tmp_path / "log.mcap") == rec
    stamp = deserialized(tmp_path / "log.mcap", "/joint_states")[0].header.stamp
    assert 10**9 * stamp.sec + stamp.nanosec == start + 2 * 10**9
    odd = Recording([2.0, 3.5], {"q.a": [1.0, 2.0]}, meta={"start_ns": "noon"})
    write_recording(odd, tmp_path / "log.mcap")
    assert read_recording(tmp_path / "log.mcap") == odd


def test_times_between_nanoseconds_are_rounded(tmp_path: Path) -> None:
    """Stamps are the nearest nanosecond, t comes back whole; two samples on one and times beyond ROS are refused."""
    path = tmp_path / "log.bag"
    rec = Recording([0.0, 1 / 3], {"q.a": [1.0, 2.0]})
    write_recording(rec, path)
    assert deserialized(path, "/joint_states")[1].header.stamp.nanosec == 333333333
    assert read_recording(path) == rec
    before = path.read_bytes()
    with pytest.raises(InputError, match=r"log.bag: t: row 1: two samples fall on one nanosecond"):
        write_recording(Recording([0.0, 1e-10], {"q.a": [1.0, 2.0]}), path)
    for times in ([0.0, 3e9], [-2e9, 1e9], [1e300, 2e300]):
        with pytest.raises(InputError, match=r"log.bag: t: ROS cannot hold the time"):
            write_recording(Recording(times, {"q.a": [1.0, 2.0]}), path)
    assert path.read_bytes() == before
    assert [each.name for each in tmp_path.iterdir()] == ["log.bag"]


def test_without_rosbags_the_extra_is_named(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Reading and writing say what to install."""
    rec = Recording([0.0, 1.0], {"q.a": [1.0, 2.0]})
    write_recording(rec, tmp_path / "log.mcap")
    monkeypatch.setitem(sys.modules, "rosbags.rosbag2", None)
    with pytest.raises(MissingExtra, match=r"flexdyn\[ros\]"):
        read_recording(tmp_path / "log.mcap")
    with pytest.raises(MissingExtra, match=r"flexdyn\[ros\]"):
        write_recording(rec, tmp_path / "log.bag")
    assert [each.name for each in tmp_path.iterdir()] == ["log.mcap"]


@pytest.mark.parametrize("suffix", KINDS)
@settings(max_examples=15, deadline=None)
@given(data=st.data())
def test_any_double_and_name(suffix: str, tmp_path_factory: pytest.TempPathFactory, data: st.DataObject) -> None:
    """Any names and numbers, at any times that ROS can stamp."""
    names = data.draw(st.lists(NAMES, min_size=1, max_size=5, unique=True))
    steps = data.draw(st.lists(st.floats(2e-9, 1e6), min_size=1, max_size=5))
    t = np.cumsum([data.draw(st.floats(-1e6, 1e6)), *steps])
    if not (np.diff(t) > 1e-9).all():
        return
    doubles = st.floats(allow_nan=False, allow_infinity=False)
    rec = Recording(t, {name: data.draw(st.lists(doubles, min_size=len(t), max_size=len(t))) for name in names})
    path = tmp_path_factory.mktemp("any") / f"log{suffix}"
    write_recording(rec, path)
    assert read_recording(path) == rec


@pytest.mark.parametrize(
    ("script", "words"),
    [
        ("INSERT INTO topics SELECT 9, '/foo', type, 'cdr', '', '' FROM topics WHERE id = 2", ""),
        ("DELETE FROM topics WHERE name = '/joint_states'", "q.a: the channel is announced and not there"),
        ("DELETE FROM topics WHERE name NOT LIKE '/flexdyn%'", "no topic with the channels that flexdyn wrote"),
        ("UPDATE topics SET type = 'std_msgs/msg/Float64' WHERE id = 2", "make no recording by themselves"),
    ],
)
def test_topics_that_were_added_or_lost(tmp_path: Path, script: str, words: str) -> None:
    """Tools merge and filter bags: what flexdyn did not write is left alone, what is missing is named."""
    path = tmp_path / "log.db3"
    rec = Recording([0.5, 1.25], {"q.a": [1.0, 2.0], "theta.a": [3.0, 4.0]})
    write_recording(rec, path)
    base = sqlite3.connect(path)
    base.execute(script)
    base.commit()
    base.close()
    if not words:
        assert read_recording(path) == rec
        return
    with pytest.raises(InputError, match=words):
        read_recording(path)
