"""Parquet: files by pandas and pyarrow are read; types, gaps and sizes that cannot be are refused."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pyarrow as pa
import pyarrow.parquet as pq
import pytest

from flexdyn.errors import InputError, MissingExtra
from flexdyn.records import Recording, parquet_file, read_recording, write_recording
from flexdyn.records.request import Request

T = np.array([0.0, 0.1, 0.2])


def saved(folder: Path, columns: dict[str, Any], **settings: Any) -> Path:
    """The columns as pyarrow writes them."""
    pq.write_table(pa.table(columns), folder / "log.parquet", **settings)
    return folder / "log.parquet"


@pytest.mark.parametrize("compression", ["snappy", "gzip", "zstd"])
@pytest.mark.parametrize("index", [None, "t", "labels"])
def test_pandas(tmp_path: Path, compression: str, index: str | None) -> None:
    """Time as a column or as the index, labels of rows, and every type of number that has an exact double."""
    frame = pd.DataFrame(
        {
            "t": T,
            "q.a": T.astype(np.float32),
            "tau.a": np.array([1, -2, 3], np.int16),
            "q.b": pd.array([1.5, 2.5, 3.5], "Float64"),
            "on": [True, False, True],
        }
    )
    frame = frame.set_index("t") if index == "t" else frame
    frame = frame.set_axis([5.0, 7.0, 9.0]) if index == "labels" else frame
    frame.to_parquet(tmp_path / "log.parquet", compression=compression)
    expected: dict[str, Any] = {
        "q.a": T.astype(np.float32),
        "tau.a": [1, -2, 3],
        "q.b": [1.5, 2.5, 3.5],
        "on": [1, 0, 1],
    }
    assert read_recording(tmp_path / "log.parquet").same_as(Recording(T, expected))


@pytest.mark.parametrize(
    "settings",
    [
        {"row_group_size": 7, "compression": "zstd", "data_page_version": "2.0"},
        {"use_dictionary": False, "use_byte_stream_split": True, "compression": "none"},
        {"data_page_size": 64, "write_statistics": False, "write_page_index": True},
    ],
)
def test_other_layouts(tmp_path: Path, settings: dict[str, Any]) -> None:
    """Row groups, pages and encodings leave no seam, bit for bit."""
    random = np.random.default_rng(4)
    t, q = np.arange(1000) * 1e-3, random.normal(size=1000)
    rec = read_recording(saved(tmp_path, {"t": t, "q.a": q, "q": -q, "q.a.b": 2 * q}, **settings))
    assert rec == Recording(t, {"q.a": q, "q": -q, "q.a.b": 2 * q})


def test_what_is_written_is_a_plain_table(tmp_path: Path) -> None:
    """Pandas finds the columns, and pyarrow the units and meta."""
    rec = Recording(T, {"q.a": [1 / 3, -0.0, 5e-324], "power": T}, meta={"units": {"q.a": "m"}, "note": "\u00fc"})
    write_recording(rec, tmp_path / "log.parquet")
    frame = pd.read_parquet(tmp_path / "log.parquet")
    assert list(frame) == ["t", "q.a", "power"]
    np.testing.assert_array_equal(frame["q.a"].to_numpy().view(np.int64), rec["q.a"].view(np.int64))
    schema = pq.read_schema(tmp_path / "log.parquet")
    assert [schema.field(name).metadata[b"units"] for name in ("t", "q.a", "power")] == [b"s", b"m", b""]
    assert read_recording(tmp_path / "log.parquet") == rec


def test_units_that_a_file_states(tmp_path: Path) -> None:
    """Metres are remembered, degrees refused."""
    path = tmp_path / "log.parquet"
    for unit in ("m", "deg"):
        fields = [pa.field("t", pa.float64()), pa.field("q.a", pa.float64(), metadata={"units": unit})]
        pq.write_table(pa.table([T, T], schema=pa.schema(fields)), path)
        if unit == "m":
            assert read_recording(path).unit("q.a") == "m"
    with pytest.raises(InputError, match=r"q\.a: the unit is not SI, got 'deg'"):
        read_recording(path)


def test_only_what_is_asked_for_is_read(tmp_path: Path) -> None:
    """Columns of any other kind beside it do not disturb; one that is not there is answered with the near miss."""
    path = saved(tmp_path, {"time": T, "note": ["a", "b", "c"], "pos": [1, None, 3], "vel": T})
    shares: list[float] = []
    table = parquet_file.read(path, Request(columns=frozenset({"vel", "time"}), mapped=True, progress=shares.append))
    assert list(table.columns) == ["time", "vel"]
    assert shares[-1] == 1.0
    with pytest.raises(InputError, match=r"tme: no such column; did you mean 'time'"):
        parquet_file.read(path, Request(columns=frozenset({"tme"}), mapped=True))


@pytest.mark.parametrize(
    ("values", "words"),
    [
        (pa.array([1.0, 2.0, None]), r"q\.a: row 2: not a finite number, got nan"),
        (pa.array([1.0, float("nan"), 2.0]), r"q\.a: row 1: not a finite number, got nan"),
        (pa.array([1, 2, None]), r"q\.a: row 2: not a finite number, got nan"),
        (pa.array([2**53 + 1, 2, 3]), r"q\.a: integers beyond 2\^53"),
        (pa.array(["a", "b", "c"]), r"q\.a: the column holds string, not doubles"),
        (pa.array(["a", "b", "a"]).dictionary_encode(), r"q\.a: the column holds dictionary"),
        (pa.array([[1.0], [2.0], [3.0]]), r"q\.a: the column holds list.*one flat column per channel"),
        (pa.array([{"x": 1.0}] * 3), r"q\.a: the column holds struct.*one flat column per channel"),
        (pa.array(np.array([0, 1, 2], "M8[us]")), r"q\.a: the column holds timestamp.*write seconds as doubles"),
        (pa.array(np.array([0, 1, 2], "m8[ms]")), r"q\.a: the column holds duration.*write seconds as doubles"),
        (pa.nulls(3), r"q\.a: the column holds null"),
    ],
)
def test_what_is_no_channel_is_refused(tmp_path: Path, values: Any, words: str) -> None:
    """One line with channel and row; nothing becomes NaN or zero in silence."""
    path = saved(tmp_path, {"t": T, "q.a": values})
    with pytest.raises(InputError, match=words) as caught:
        read_recording(path)
    assert caught.value.channel == "q.a"
    assert str(caught.value).startswith(str(path))


def test_a_gap_is_found_in_its_row_across_row_groups(tmp_path: Path) -> None:
    """Rows count through the file."""
    values = [float(k) for k in range(50)] + [None]
    path = saved(tmp_path, {"t": np.arange(51.0), "q.a": values}, row_group_size=8)
    with pytest.raises(InputError, match="row 50: not a finite number"):
        read_recording(path)


def test_time_must_be_there(tmp_path: Path) -> None:
    """A column that looks like time is named; labels that pandas wrote are no channel."""
    with pytest.raises(InputError, match="no column t; did you mean 'time'"):
        read_recording(saved(tmp_path, {"time": T, "q.a": T}))
    pd.DataFrame({"q.a": T}, index=T).to_parquet(tmp_path / "log.parquet")
    with pytest.raises(InputError, match="no column t"):
        read_recording(tmp_path / "log.parquet")


def test_sizes_that_no_honest_file_has_are_refused(tmp_path: Path) -> None:
    """Millions of equal numbers in a small file are not unpacked."""
    zeros = np.zeros(5_000_000, np.int8)
    path = saved(tmp_path, {"t": zeros, "q.a": zeros}, compression="zstd")
    assert path.stat().st_size < 50_000
    with pytest.raises(InputError, match="declares 80000000 bytes of arrays"):
        read_recording(path)


def test_without_pyarrow_the_extra_is_named(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Reading and writing say what to install."""
    path = saved(tmp_path, {"t": T, "q.a": T})
    monkeypatch.setitem(sys.modules, "pyarrow", None)
    for use in (read_recording, lambda target: write_recording(Recording(T, {"q.a": T}), target)):
        with pytest.raises(MissingExtra, match=r"flexdyn\[parquet\]"):
            use(path)
