"""Repairs: nothing happens unasked, what happens is listed, and every error names the repair that would do."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest
from hypothesis import given
from hypothesis import strategies as st

import flexdyn as fd
from flexdyn.errors import InputError
from flexdyn.records.meta import as_plain
from flexdyn.records.recording import Recording
from flexdyn.records.repairs import repaired, repairs_of
from flexdyn.records.table import Table

NAN = float("nan")


def mended(t: Any, x: Any, *repairs: Any) -> Recording:
    """The recording that repairs make of time and one channel."""
    table = Table({"t": np.array(t, float), "q.a": np.array(x, float)})
    return Recording.from_table(repaired(table, repairs_of(repairs)))


@pytest.mark.parametrize(
    ("t", "x", "repairs", "kept_t", "kept_x", "touched"),
    [
        ([0, 2, 1, 3], [0, 2, 1, 3], ["sort_time"], [0, 1, 2, 3], [0, 1, 2, 3], [2]),
        ([0, 1, 1, 1, 2], [0, 1, 8, 9, 2], ["drop_duplicate_times"], [0, 1, 2], [0, 1, 2], [2]),
        ([0, 2, 1, 1.5, 3], [0, 2, 8, 9, 3], ["drop_backwards"], [0, 2, 3], [0, 2, 3], [2]),
        ([0, 1, 0, 1, 2], [0, 1, 8, 9, 2], ["sort_time", "drop_duplicate_times"], [0, 1, 2], [0, 1, 2], [2, 2]),
        ([0, 1, 0, 1, 2], [0, 1, 8, 9, 2], ["drop_duplicate_times"], [0, 1, 2], [0, 1, 2], [2]),
        ([0, 1, 2, 3], [0, NAN, float("inf"), 3], ["drop_nan"], [0, 3], [0, 3], [2]),
        ([0, NAN, 2, 3], [0, 1, 2, 3], ["drop_nan"], [0, 2, 3], [0, 2, 3], [1]),
        ([0, NAN, 2, 1], [0, 1, 2, 3], ["drop_backwards", "drop_nan"], [0, 2], [0, 2], [1, 1]),
        ([0, 0.01, 0.03], [0, NAN, 6], ["fill_nan"], [0, 0.01, 0.03], [0, 2, 6], [1]),
        ([0, 1, 3], [0, NAN, 6], [{"fill_nan": {"longest": 3}}], [0, 1, 3], [0, 2, 6], [1]),
        ([0, 1, 2], [0, 1, 2], ["sort_time", "drop_nan", "fill_nan"], [0, 1, 2], [0, 1, 2], [0, 0, 0]),
    ],
)
def test_what_repairs_do(t: Any, x: Any, repairs: Any, kept_t: Any, kept_x: Any, touched: list[int]) -> None:
    """Each does its own, in the order asked for, and says how many rows it touched."""
    rec = mended(t, x, *repairs)
    np.testing.assert_allclose(rec.t, kept_t, rtol=1e-15)
    np.testing.assert_allclose(rec["q.a"], kept_x, rtol=1e-15)
    assert [entry["rows"] for entry in rec.meta["repairs"]] == touched


@given(st.lists(st.one_of(st.just(NAN), st.floats(-1e3, 1e3)), min_size=1, max_size=30))
def test_together_they_mend_any_clock(times: list[float]) -> None:
    """Whatever the times are, what is left increases strictly, and rows stay whole."""
    t = [*times, 2e3, 3e3]
    rec = mended(t, np.array(t) * 2, "drop_nan", "sort_time", "drop_duplicate_times")
    assert (np.diff(rec.t) > 0).all()
    np.testing.assert_array_equal(rec["q.a"], rec.t * 2)
    np.testing.assert_array_equal(rec.t, np.unique([time for time in t if time == time]))
    forwards = mended(t, np.array(t) * 2, "drop_nan", "drop_backwards", "drop_duplicate_times")
    assert set(forwards.t) <= set(rec.t)
    assert forwards.t[0] == next(time for time in t if time == time)


def test_repairs_of_a_file_are_asked_for_and_listed(tmp_path: Path) -> None:
    """A sound log stays as it is unless asked; a broken one is refused until asked; the list is kept in files."""
    path = tmp_path / "log.csv"
    path.write_text("t,q.a\n0,0\n2,2\n1,1\n1,7\n3,nan\n4,4\n")
    for repairs in ([], ["sort_time"], ["sort_time", "drop_duplicate_times"]):
        with pytest.raises(InputError):
            fd.read_recording(path, repair=repairs)
    rec = fd.read_recording(path, repair=["sort_time", "drop_duplicate_times", {"fill_nan": {"longest": 2.5}}])
    np.testing.assert_array_equal(rec["q.a"], [0, 1, 2, 3, 4])
    listed = [("sort_time", 3), ("drop_duplicate_times", 1), ("fill_nan", 1)]
    assert as_plain(rec.meta)["repairs"] == [{"repair": name, "rows": rows} for name, rows in listed]
    fd.write_recording(rec, tmp_path / "log.npz")
    assert fd.read_recording(tmp_path / "log.npz") == rec


def test_repairs_of_a_map_come_first(tmp_path: Path) -> None:
    """Those of the call follow; the clock's start is taken from what is left."""
    path = tmp_path / "log.csv"
    path.write_text("stamp,x\n12,2\n11,1\n11,9\n13,3\n")
    content = {"flexdyn_map": 1, "time": {"from": "stamp", "start": "zero"}, "channels": {"q.a": "x"}}
    rec = fd.read_recording(
        path, map=fd.ChannelMap.from_dict(content | {"repair": ["sort_time"]}), repair=["drop_duplicate_times"]
    )
    np.testing.assert_array_equal(rec.t, [0, 1, 2])
    np.testing.assert_array_equal(rec["q.a"], [1, 2, 3])
    assert [entry["repair"] for entry in rec.meta["repairs"]] == ["sort_time", "drop_duplicate_times"]


@pytest.mark.parametrize(
    ("text", "repair", "line"),
    [
        (
            "0,0\n2,2\n1,1\n",
            [],
            "t: line 4: time runs backwards, from 2.0 s, got 1.0; t must increase strictly (repair so",
        ),
        (
            "0,0\n1,2\n1,1\n",
            [],
            "t: line 4: two samples at one time, got 1.0; t must increase strictly (repair drop_dupl",
        ),
        (
            "0,0\n1,nan\n2,1\n",
            [],
            "q.a: line 3: not a finite number, got nan; remove or fill the gap (repair drop_nan or",
        ),
        (
            "0,0\n1,nan\n2,1\n",
            ["fill_nan"],
            "q.a: line 3: a gap of 2 s, longer than 0.1 s; allow it with {fill_nan: {longest: 2",
        ),
        (
            "0,0\n1,nan\n",
            ["fill_nan"],
            "q.a: line 3: the gap has no sample on one side; drop_nan drops such rows",
        ),
        (
            "0,nan\n1,0\n",
            ["fill_nan"],
            "q.a: line 2: the gap has no sample on one side; drop_nan drops such rows",
        ),
        ("nan,0\n1,0\n", ["fill_nan"], "t: line 2: the time itself is missing; drop_nan"),
        ("1,0\n1,nan\n1,1\n", ["fill_nan"], "t: line 4: times do not increase; repair the times first: sort_time"),
        ("nan,0\n1,0\n1,1\n", ["drop_nan"], "t: line 4: two samples at one time, got 1.0; "),
        ("0,0\n", ["drop_nan"], "t: 1 samples are too few; give two or more"),
        ("0,0\n1,1\n", ["sort"], "repair: no such repair, got 'sort'; did you mean 'sort_time'?"),
        (
            "0,0\n1,1\n",
            ["drop_times"],
            "repair: no such repair, got 'drop_times'; did you mean 'drop_duplicate_times'?",
        ),
        ("0,0\n1,1\n", [3], "repair: no such repair, got 3; known: sort_time, drop_duplicate_times, drop_backwards"),
    ],
)
def test_errors_name_row_channel_and_repair(tmp_path: Path, text: str, repair: list[Any], line: str) -> None:
    """Rows are those of the file, whatever was dropped before them."""
    path = tmp_path / "log.csv"
    path.write_text("t,q.a\n" + text)
    with pytest.raises(InputError, match=re.escape(line)):
        fd.read_recording(path, repair=repair)


def test_gaps_that_pandas_wrote_can_be_filled(tmp_path: Path) -> None:
    """NaN goes into Parquet as a missing value, and is mended as NaN."""
    pd.DataFrame({"t": [0.0, 0.01, 0.02], "q.a": [0.0, NAN, 2.0]}).to_parquet(tmp_path / "log.parquet")
    rec = fd.read_recording(tmp_path / "log.parquet", repair=["fill_nan"])
    np.testing.assert_array_equal(rec["q.a"], [0, 1, 2])
