"""Recordings and pandas: there and back without loss, gaps and dates; and a recording read like a dict."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

import flexdyn as fd
from flexdyn.errors import InputError
from flexdyn.records import Recording
from flexdyn.records.given import as_recording, as_recordings
from tests.diagnose import slides
from tests.diagnose.stopped import taken_by_a_diagnosis

T = np.array([0.1, 0.2, 0.3])
REC = Recording(
    T, {"q.a": [1 / 3, -0.0, 5e-324], "q.lift": T, "note": T}, meta={"units": {"q.lift": "m"}, "x": [1]}, name="mine"
)


def test_there_and_back_is_bit_for_bit() -> None:
    """Times are the index, channels the columns; units, meta and name come back too."""
    frame = REC.to_pandas()
    assert list(frame.columns) == ["q.a", "q.lift", "note"]
    assert frame.index.name == "t"
    again = Recording.from_pandas(frame)
    assert again == REC
    assert again.name == "mine"
    assert Recording.from_pandas(frame.reset_index()).same_as(REC)
    frame.loc[0.1, "q.a"] = 7.0
    assert REC["q.a"][0] == 1 / 3


def test_work_done_in_pandas_comes_back() -> None:
    """Rows cut, a column added, one renamed."""
    frame = REC.to_pandas().iloc[1:].assign(extra=[1, 2]).rename(columns={"note": "tau.a"})
    rec = Recording.from_pandas(frame, name="other")
    assert list(rec) == ["q.a", "q.lift", "tau.a", "extra"]
    assert (rec.name, rec.unit("q.lift")) == ("other", "m")
    np.testing.assert_array_equal(rec.t, T[1:])


def test_dates_and_time_spans_are_seconds() -> None:
    """As the index or as a column t; the date of the first is kept."""
    dates = pd.date_range("2024-05-03 12:00", periods=3, freq="250ms", tz="Europe/Berlin")
    for frame in (
        pd.DataFrame({"q.a": T}, index=dates),
        pd.DataFrame({"q.a": T, "t": dates}),
    ):
        rec = Recording.from_pandas(frame)
        np.testing.assert_array_equal(rec.t, [0.0, 0.25, 0.5])
        assert rec.meta["start_ns"] == dates[0].value
    spans = pd.DataFrame({"q.a": T}, index=pd.to_timedelta([5, 10, 20], unit="ms"))
    np.testing.assert_array_equal(Recording.from_pandas(spans).t, [0.005, 0.01, 0.02])


def test_columns_of_two_levels_and_units_in_names() -> None:
    """(signal, joint), and SI units in brackets; degrees are refused."""
    levels = pd.DataFrame({("q", "a"): T, ("tau", "a"): T}, index=T)
    assert list(Recording.from_pandas(levels)) == ["q.a", "tau.a"]
    named = pd.DataFrame({"t [s]": T, "q.a [rad]": T, "q.lift [m]": T})
    rec = Recording.from_pandas(named)
    assert (list(rec), rec.unit("q.lift")) == (["q.a", "q.lift"], "m")
    with pytest.raises(InputError, match=r"q\.a: the unit is not SI, got 'deg'"):
        Recording.from_pandas(pd.DataFrame({"t": T, "q.a [deg]": T}))


@pytest.mark.parametrize("kind", ["float64", "Float64", "object"])
def test_what_pandas_has_not_is_a_gap(kind: str) -> None:
    """NaN, NA and None are named with their row, and repaired on request."""
    frame = pd.DataFrame({"t": T, "q.a": pd.Series([1.0, None, 3.0], dtype=kind)})
    with pytest.raises(InputError, match=r"q\.a: row 1: not a finite number.*fill_nan"):
        Recording.from_pandas(frame)
    rec = Recording.from_pandas(frame, repair=[{"fill_nan": {"longest": 0.3}}])
    np.testing.assert_allclose(rec["q.a"], [1.0, 2.0, 3.0], rtol=1e-15)


def test_what_is_no_recording_is_named() -> None:
    """Text, names that stand twice, an index that counts rows from 0 at one time, something that is no frame."""
    with pytest.raises(InputError, match=r"q\.a: the column holds no numbers"):
        Recording.from_pandas(pd.DataFrame({"t": T, "q.a": ["x", "y", "z"]}))
    with pytest.raises(InputError, match="several columns have one name"):
        Recording.from_pandas(pd.DataFrame(np.ones((3, 2)), columns=["q.a", "q.a"], index=T))
    with pytest.raises(InputError, match=r"a pandas\.DataFrame is needed, got 'dict'"):
        Recording.from_pandas({"q.a": T})
    with pytest.raises(InputError, match="time runs backwards"):
        Recording.from_pandas(pd.DataFrame({"q.a": T}, index=T[::-1]))


def test_a_recording_is_read_like_a_mapping() -> None:
    """Channels by iteration, `in`, keys, values and items; the samples are counted by len; times are rec.t."""
    assert list(REC) == ["q.a", "q.lift", "note"] == list(REC.keys())
    assert "q.a" in REC
    assert "t" not in REC
    assert {name: values[0] for name, values in REC.items()} == {"q.a": 1 / 3, "q.lift": 0.1, "note": 0.1}
    assert dict(REC)["note"] is REC["note"]
    assert len(REC) == len(next(iter(REC.values()))) == 3
    with pytest.raises(InputError, match=r"t: no such channel; the times are rec\.t"):
        _ = REC["t"]


def test_a_path_a_frame_or_a_run_stands_for_a_recording(tmp_path: Path) -> None:
    """One or several; anything else is refused with what would do."""
    fd.write_recording(REC, tmp_path / "log.h5")
    assert as_recording(tmp_path / "log.h5") == REC
    assert as_recordings(str(tmp_path / "log.h5")) == (REC,)
    assert as_recordings([REC, REC.to_pandas(), REC.to_xarray()]) == (REC, REC, REC)
    run = fd.simulate(fd.load_model("scara_two_link"), duration=0.01)
    assert as_recordings(run)[0].same_as(run.to_recording())
    for wrong in (3, [REC, 3], {"q.a": T}):
        with pytest.raises(InputError, match=r"recordings.*neither a run nor a recording, .*give what fd\.simulate"):
            as_recordings(wrong)
    with pytest.raises(InputError, match=r"did you mean q\.a for q_a"):
        as_recordings(Recording(T, {"q_a": T}))


def test_functions_take_paths_and_frames(tmp_path: Path) -> None:
    """simulate, plot, compare, base_parameters and steady_points give what they give of the recording."""
    model = fd.load_model("scara_two_link")
    t = np.arange(400) * 1e-3
    tau = fd.Samples(t, np.column_stack([np.sin(9 * t), np.cos(7 * t)]))
    rec = fd.simulate(model, tau, rate=1000).to_recording()
    fd.write_recording(rec, tmp_path / "log.h5")
    path, frame = tmp_path / "log.h5", rec.to_pandas()
    runs = [fd.simulate(model, given, duration=0.1) for given in (rec, path, frame)]
    assert all(np.array_equal(run.q, runs[0].q) for run in runs)
    assert fd.compare(frame, path).rows == fd.compare(rec, rec).rows
    assert len(fd.plot(frame, path).panels) == len(fd.plot(rec, rec).panels)
    bases = [fd.base_parameters(model, given) for given in (rec, str(path), frame)]
    assert len({base.condition for base in bases}) == 1
    points = [fd.steady_points(given, "elbow")[0].torque for given in ([rec], path, frame)]
    assert len(set(points)) == 1


def test_a_diagnosis_takes_paths_and_frames(tmp_path: Path) -> None:
    """One path or several, for fit and check, are the recordings in them."""
    model, rec = slides.model(tmp_path), slides.recording(lambda v: 0.0, seconds=4.0)
    fd.write_recording(rec, tmp_path / "a.h5")
    given = [rec.to_pandas(), str(tmp_path / "a.h5")]
    assert taken_by_a_diagnosis(model, tmp_path / "a.h5", given) == [("a", 0.0, 2000)]
    taken = taken_by_a_diagnosis(model, given, rec)
    assert [(begin, samples) for _, begin, samples in taken] == [(0.0, 2000), (0.0, 2000)]
    assert taken[1][0] == "a"
    with pytest.raises(InputError, match=r"check\[1\]: neither a run nor a recording"):
        fd.diagnose(model, rec, check=[rec, 3])
    with pytest.raises(InputError, match=r"fit\[1\]: neither a run nor a recording"):
        fd.diagnose(model, fit=[rec, 3])


def test_importing_flexdyn_does_not_import_pandas() -> None:
    """It costs half a second."""
    code = "import sys, flexdyn as fd; fd.Recording([0, 1], {'q.a': [0, 1]}); print('pandas' in sys.modules)"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout == "False\n"
