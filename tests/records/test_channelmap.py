"""A channel map applied: columns, clocks, couplings, and what the recording remembers of it."""

from __future__ import annotations

import re
from pathlib import Path

import h5py
import numpy as np
import pandas as pd
import pytest
import scipy.io
from hypothesis import given
from hypothesis import strategies as st

import flexdyn as fd
from flexdyn.errors import InputError
from flexdyn.records.meta import as_plain
from tests.records.mapping import channel_map, mapped

LOG = """\
Robot: left arm
 ;position;current;note
ms;deg;A;
10;90;2,0;0
20;180;-4,0;0
30;270;6,0;0
"""
MAP = """\
flexdyn_map: 1
source: {names_line: 2, first_line: 4, delimiter: ";", decimal: ","}
time: {from: 1, unit: ms, start: zero, shift: 0.5}
joints: {elbow: {gear_ratio: 100, torque_constant: 0.05}}
channels:
  q.elbow: {from: position, unit: deg, sign: -1}
  tau.elbow: {from: 3, unit: A, side: motor}
"""


def files(folder: Path, log: str = LOG, text: str = MAP) -> tuple[Path, Path]:
    """A log as somebody's program writes it, and its map."""
    (folder / "log.csv").write_text(log, encoding="utf-8")
    (folder / "map.yaml").write_text(text, encoding="utf-8")
    return folder / "log.csv", folder / "map.yaml"


def test_a_log_and_its_map(tmp_path: Path) -> None:
    """Names, numbers of columns, decimal commas, units, clock: all at once, by path or as a map."""
    log, path = files(tmp_path)
    rec = fd.read_recording(log, map=path)
    np.testing.assert_allclose(rec.t, [0.5, 0.51, 0.52], rtol=1e-15)
    np.testing.assert_allclose(rec["q.elbow"], [-np.pi / 2, -np.pi, -1.5 * np.pi], rtol=1e-15)
    np.testing.assert_allclose(rec["tau.elbow"], [10, -20, 30], rtol=1e-15)
    assert tuple(rec.channels) == ("q.elbow", "tau.elbow")
    assert fd.read_recording(log, map=fd.read_map(path)) == rec


def test_the_recording_remembers_its_map(tmp_path: Path) -> None:
    """A converted file says where its numbers came from; mapped once more, it says both."""
    log, path = files(tmp_path)
    rec = fd.read_recording(log, map=path)
    assert fd.ChannelMap.from_dict(as_plain(rec.meta)["map"]) == fd.read_map(path)
    fd.write_recording(rec, tmp_path / "log.npz")
    assert fd.read_recording(tmp_path / "log.npz") == rec
    again = fd.read_recording(tmp_path / "log.npz", map=channel_map(channels={"theta.elbow": "q.elbow"}))
    assert as_plain(again.meta)["earlier_maps"] == [as_plain(rec.meta)["map"]]
    assert as_plain(again.meta)["map"]["channels"] == {"theta.elbow": {"from": "q.elbow"}}


def test_a_column_that_is_not_there(tmp_path: Path) -> None:
    """The near miss among the file's own columns is named, in any format."""
    log, _ = files(tmp_path, "time,pos_meas1\n0,1\n1,2\n")
    fd.write_recording(fd.Recording([0, 1], {"pos_meas1": [1, 2]}), tmp_path / "log.npz")
    fd.write_recording(fd.Recording([0, 1], {"pos_meas1": [1, 2]}), tmp_path / "log.h5")
    for path, time in ((log, "time"), (tmp_path / "log.npz", "t"), (tmp_path / "log.h5", "t")):
        with pytest.raises(InputError, match=r"pos_meas: .*no such column; did you mean 'pos_meas1'\?") as caught:
            fd.read_recording(path, map=channel_map(time=time, channels={"q.a": "pos_meas"}))
        assert str(caught.value).startswith(str(path))


def test_what_nobody_names_is_not_read(tmp_path: Path) -> None:
    """A column of another length and one of text do not matter while nobody wants them."""
    np.savez(tmp_path / "log.npz", t=[0.0, 1.0], pos=[1.0, 2.0], gain=[3.0], label=np.array(["a", "b"]))
    with h5py.File(tmp_path / "log.h5", "w") as file:
        file["t"], file["pos"], file["robot/gain"], file["robot/label"] = [0.0, 1.0], [1.0, 2.0], [3.0], b"a"
    for name in ("log.npz", "log.h5"):
        rec = fd.read_recording(tmp_path / name, map=channel_map(channels={"q.a": "pos"}))
        assert tuple(rec.channels) == ("q.a",)


def test_others_are_kept_on_request() -> None:
    """They come along bit for bit, with what the file says of their units."""
    raw = {"time": [0, 1], "pos": [90, 180], "power": [1.5, 2.5]}
    rec = mapped(raw, {"power": "W"}, time="time", channels={"q.a": {"from": "pos", "unit": "deg"}}, others="keep")
    np.testing.assert_array_equal(rec["power"], [1.5, 2.5])
    assert (tuple(rec.channels), rec.unit("power")) == (("q.a", "power"), "W")
    with pytest.raises(InputError, match=r"q\.b: the unit is not SI, got 'deg'"):
        mapped({"t": [0, 1], "q.b": [0, 1]}, {"q.b": "deg"}, others="keep")
    with pytest.raises(InputError, match=r"others: the map makes a channel that the file has too, got 'q\.a'"):
        mapped({"t": [0, 1], "q.a": [0, 1], "x": [0, 1]}, channels={"q.a": "x"}, others="keep")


def test_rows_are_counted_where_there_is_no_time() -> None:
    """The first row is at zero."""
    rec = mapped({"x": [1, 2, 3]}, time={"rate": 250, "shift": 1}, channels={"q.a": "x"})
    np.testing.assert_array_equal(rec.t, [1.0, 1.004, 1.008])


def test_nanoseconds_since_1970() -> None:
    """No digit is lost where the first is subtracted; where it is not, doubles cannot hold them."""
    stamps = np.array([1_600_000_000_000_000_001, 1_600_000_000_000_001_002, 1_600_000_000_000_002_004])
    for kind in (np.int64, np.uint64):
        raw = {"stamp": stamps.astype(kind), "x": [1, 2, 3]}
        rec = mapped(raw, time={"from": "stamp", "unit": "ns", "start": "zero"}, channels={"q.a": "x"})
        np.testing.assert_array_equal(rec.t, [0.0, 1001 / 1e9, 2003 / 1e9])
    with pytest.raises(InputError, match=r"time.start: integers beyond 2\^53 .* got 'stamp'; give start: zero"):
        mapped(raw, time={"from": "stamp", "unit": "ns"}, channels={"q.a": "x"})


def test_times_of_a_file_that_says_their_unit() -> None:
    """A contradicting or strange unit is refused."""
    raw = {"t": [0, 1], "x": [0, 1]}
    with pytest.raises(InputError, match=r"time\.unit: not the unit that the file states, got 's'; the file says 'ms'"):
        mapped(raw, {"t": "ms"}, time={"unit": "s"}, channels={"q.a": "x"})
    for stated in ("fortnight", "deg", None):
        with pytest.raises(InputError, match=r"time\.unit: the file states a unit of time that is not known"):
            mapped(raw, {"t": stated}, channels={"q.a": "x"})


@given(st.floats(-0.3, 0.3), st.floats(-0.3, 0.3))
def test_a_delayed_channel_is_moved_back(delay: float, other: float) -> None:
    """A ramp and a parabola sampled with late stamps come back at the common times; only the ends are lost."""
    t = np.sort(np.concatenate([np.linspace(0, 2, 201), [0.0031, 1.234]]))
    raw = {"t": t, "ramp": 3 * (t - delay), "parabola": (t - other) ** 2, "sure": t}
    channels = {
        "q.a": {"from": "ramp", "delay": delay},
        "q.b": {"from": "parabola", "delay": other},
        "q.c": "sure",
    }
    rec = mapped(raw, channels=channels)
    np.testing.assert_array_equal(rec["q.c"], rec.t)
    np.testing.assert_allclose(rec["q.a"], 3 * rec.t, atol=1e-6)
    np.testing.assert_allclose(rec["q.b"], rec.t**2, atol=0.01**2 / 4 + 1e-6)  # h^2/8 |x''| of linear interpolation
    first, last = -min(delay, other, 0), 2 - max(delay, other, 0)
    assert set(t[(t >= first) & (t <= last)]) <= set(rec.t) <= set(t[(t >= first - 1e-6) & (t <= last + 1e-6)])


def test_a_delay_of_whole_samples_only_shifts() -> None:
    """No sample more than the delay is lost to rounding."""
    t = np.arange(100) * 0.001
    rec = mapped({"t": t, "x": t, "y": t}, channels={"q.a": {"from": "x", "delay": 0.002}, "q.b": "y"})
    assert len(rec) == 98
    np.testing.assert_allclose(rec["q.a"], rec.t + 0.002, rtol=0, atol=1e-15)


@pytest.mark.parametrize(
    ("raw", "delay", "line"),
    [
        ({"t": [0, 1, 2], "x": [0, 1, 2]}, 5, "channels.q.a.delay: the delay leaves 0 samples of 2 s, got 5"),
        ({"t": [0, 2, 1], "x": [0, 1, 2]}, 0.1, "t: row 2: time runs backwards, from 2.0 s, got 1.0"),
        ({"t": [0, 1, 2], "x": [0, np.nan, 2]}, 0.1, "q.a: row 1: not a finite number, got nan"),
    ],
)
def test_delays_that_cannot_be_undone(raw: dict[str, list[float]], delay: float, line: str) -> None:
    """Too long a delay, or a log that needs a repair first."""
    with pytest.raises(InputError, match=re.escape(line)):
        mapped(raw, channels={"q.a": {"from": "x", "delay": delay}})


matrices = st.lists(st.floats(-3, 3), min_size=9, max_size=9).map(lambda rows: np.reshape(rows, (3, 3)))


@given(matrices.filter(lambda matrix: np.linalg.cond(matrix) < 1e4), st.integers(0, 1000))
def test_couplings_keep_the_power(position: np.ndarray, seed: int) -> None:
    """tau_joints . omega_joints = tau_motors . omega_motors where torque is left out; theta = P theta_motors."""
    motors = np.random.default_rng(seed).normal(size=(3, 3, 20))
    raw = {"t": np.arange(20.0)}
    channels = {}
    for signal, rows in zip(("theta", "omega", "tau"), motors, strict=True):
        for joint, values in zip("abc", rows, strict=True):
            raw[f"{signal}{joint}"] = values
            channels[f"{signal}.{joint}"] = f"{signal}{joint}"
    couplings = [{"joints": ["a", "b", "c"], "position": position.tolist()}]
    rec = mapped(raw, channels=channels, couplings=couplings)
    theta, omega, tau = (rec.signal(signal, ["a", "b", "c"]) for signal in ("theta", "omega", "tau"))
    np.testing.assert_allclose(theta, motors[0].T @ position.T, atol=1e-12)
    power = (motors[1] * motors[2]).sum(axis=0)
    np.testing.assert_allclose((omega * tau).sum(axis=1), power, atol=1e-10 * np.linalg.cond(position) ** 2)


def test_a_differential_wrist() -> None:
    """Both motors alike pitch, both against each other roll; other joints, and given torque matrices, as written."""
    channels = {f"theta.{joint}": joint for joint in ("pitch", "roll", "elbow")}
    channels |= {"tau.pitch": "pitch", "tau.roll": "roll", "q.pitch": "roll", "q.roll": "pitch"}
    raw = {"t": [0, 1], "pitch": [1.0, 1.0], "roll": [1.0, -1.0], "elbow": [7.0, 8.0]}
    wrist = {"joints": ["pitch", "roll"], "position": [[0.5, 0.5], [0.5, -0.5]]}
    rec = mapped(raw, channels=channels, couplings=[wrist])
    np.testing.assert_array_equal(rec.signal("theta", ["pitch", "roll", "elbow"]), [[1, 0, 7], [0, 1, 8]])
    np.testing.assert_array_equal(rec.signal("tau", ["pitch", "roll"]), [[2, 0], [0, 2]])
    np.testing.assert_array_equal(rec["q.pitch"], [1.0, -1.0])
    given = mapped(raw, channels=channels, couplings=[{**wrist, "torque": [[3, 0], [0, 5]], "signals": ["q"]}])
    np.testing.assert_array_equal(given.signal("tau", ["pitch", "roll"]), [[3, 5], [3, -5]])
    np.testing.assert_array_equal(given.signal("q", ["pitch", "roll"]), [[1, 0], [0, -1]])
    np.testing.assert_array_equal(given["theta.pitch"], [1.0, 1.0])


def test_errors_after_mapping_name_file_line_and_channel(tmp_path: Path) -> None:
    """Rows are those of the file."""
    log, path = files(tmp_path, LOG.replace("-4,0", "nan"))
    with pytest.raises(InputError) as caught:
        fd.read_recording(log, map=path)
    assert str(caught.value).startswith(f"{log}: tau.elbow: line 5: not a finite number, got nan; ")


def test_columns_of_other_lengths() -> None:
    """The shorter column is named with the row it lacks."""
    with pytest.raises(InputError, match=r"q\.a: 1 samples where t has 2"):
        mapped({"t": [0, 1], "x": [1]}, channels={"q.a": "x"})


@pytest.mark.parametrize("suffix", [".csv", ".npz", ".h5", ".parquet", ".mat"])
def test_others_are_kept_in_any_format(tmp_path: Path, suffix: str) -> None:
    """The file needs no column t of its own, and what is kept comes through bit for bit."""
    raw = {
        "stamp": np.array([1.0, 2.0, 3.0]),
        "pos": np.array([90.0, 180.0, 270.0]),
        "power": np.array([0.1, 0.2, 1 / 3]),
    }
    path = tmp_path / f"log{suffix}"
    if suffix == ".csv":
        rows = zip(*raw.values(), strict=True)
        path.write_text("\n".join([",".join(raw), *(",".join(map(repr, map(float, row))) for row in rows)]))
    elif suffix == ".npz":
        np.savez(path, **raw)  # type: ignore[arg-type]
    elif suffix == ".h5":
        with h5py.File(path, "w") as file:
            file.update(raw)
    elif suffix == ".parquet":
        pd.DataFrame(raw).to_parquet(path)
    else:
        scipy.io.savemat(path, raw)
    channels = {"q.a": {"from": "pos", "unit": "deg"}}
    rec = fd.read_recording(path, map=channel_map(time="stamp", channels=channels, others="keep"))
    np.testing.assert_array_equal(rec.t, raw["stamp"])
    np.testing.assert_allclose(rec["q.a"], np.array([0.5, 1.0, 1.5]) * np.pi, rtol=1e-15)
    np.testing.assert_array_equal(rec["power"], raw["power"])
    dropped = fd.read_recording(path, map=channel_map(time="stamp", channels=channels))
    assert tuple(dropped.channels) == ("q.a",)
