"""CSV files as people have them: empty cells, letters of Windows, dates, units behind names, decimal commas."""

from __future__ import annotations

import re
import warnings
from datetime import datetime, timedelta, timezone
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

import flexdyn as fd
from flexdyn.cli import main
from flexdyn.errors import InputError
from flexdyn.records import Recording, RecordingWarning, read_recording
from flexdyn.records.channelmap.description import ChannelMap
from flexdyn.records.suggestion import columns_of_arrays, suggested_map

T = np.array([0.0, 0.1, 0.2, 0.3])
Q = np.array([0.5, 0.6, np.nan, 0.8])
GERMAN = """\
Prüfstand 3;;
Zeit [s];Soll [°];Ist [°];Moment [Nm]
0,000;10,0;9,5;1,25
0,001;10,0;9,75;
0,002;10,0;10,0;-1,5
"""


def saved(folder: Path, text: str, encoding: str = "utf-8") -> Path:
    """The text as a file."""
    path = folder / "log.csv"
    path.write_bytes(text.encode(encoding))
    return path


@pytest.mark.parametrize("blank", ["", "NA", "null", "nan", " "])
@pytest.mark.parametrize("separator", [",", ";", "\t"])
def test_empty_cells_of_pandas_are_gaps_to_be_repaired(tmp_path: Path, blank: str, separator: str) -> None:
    """Without a repair the line says which cell; a repair drops the row or fills it along the straight line."""
    frame = pd.DataFrame({"t": T, "q.a": Q, "tau.a": [1.0, 2.0, 3.0, np.nan]})
    frame.to_csv(tmp_path / "log.csv", index=False, na_rep=blank, sep=separator)
    with pytest.raises(InputError, match=r"q\.a: line 4: not a finite number.*drop_nan or fill_nan"):
        read_recording(tmp_path / "log.csv")
    whole = read_recording(tmp_path / "log.csv", repair=["drop_nan"])
    assert whole.same_as(Recording(T[:2], {"q.a": Q[:2], "tau.a": [1.0, 2.0]}))
    assert whole.meta["repairs"] == ({"repair": "drop_nan", "rows": 2},)
    frame["tau.a"] = [1.0, 2.0, 3.0, 4.0]
    frame.to_csv(tmp_path / "log.csv", index=False, na_rep=blank, sep=separator)
    filled = read_recording(tmp_path / "log.csv", repair=[{"fill_nan": {"longest": 0.25}}])
    assert filled["q.a"][2] == pytest.approx(0.7, abs=1e-15)


def test_a_long_file_with_empty_cells_is_read_whole(tmp_path: Path) -> None:
    """Cells are empty in some blocks of the file and not in others."""
    values = np.random.default_rng(1).normal(size=150_000)
    values[[10, 149_990]] = np.nan
    t = np.arange(150_000) * 1e-3
    pd.DataFrame({"t": t, "q.a": values}).to_csv(tmp_path / "log.csv", index=False)
    rec = read_recording(tmp_path / "log.csv", repair=["drop_nan"])
    np.testing.assert_array_equal(rec["q.a"], values[np.isfinite(values)])


@pytest.mark.parametrize("text", ["t,q.a\n0,1\n1,x\n", "t,q.a\n0,\n1,x\n", "t,q.a\n0,1\n1,N\n"])
def test_other_text_is_still_refused(tmp_path: Path, text: str) -> None:
    """An empty cell elsewhere does not hide it."""
    with pytest.raises(InputError, match=r"q\.a: line 3: not a number"):
        read_recording(saved(tmp_path, text))


def test_a_separator_may_end_the_lines(tmp_path: Path) -> None:
    """As many loggers write it, names included."""
    assert read_recording(saved(tmp_path, "t;q.a;\n0;1;\n1;2;\n")).same_as(Recording([0, 1], {"q.a": [1, 2]}))


@pytest.mark.parametrize("encoding", ["latin-1", "cp1252", "ISO-8859-15"])
def test_letters_are_read_as_the_map_says(tmp_path: Path, encoding: str) -> None:
    """Nothing is guessed then, and nothing said."""
    path = saved(tmp_path, "Zeit;Größe\n0;1\n1;2\n", encoding)
    layout = {"flexdyn_map": 1, "source": {"encoding": encoding}, "time": "Zeit", "channels": {"q.a": "Größe"}}
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        rec = read_recording(path, map=ChannelMap.from_dict(layout))
    assert rec.same_as(Recording([0, 1], {"q.a": [1, 2]}))
    assert rec.meta["map"]["source"] == {"encoding": encoding}


def test_guessed_letters_are_said(tmp_path: Path) -> None:
    """A file that is not UTF-8 is read as Windows writes it; the warning says so and what to do, the meta keeps it."""
    path = saved(tmp_path, "t;q.Größe\n0;1\n1;2\n", "latin-1")
    with pytest.warns(RecordingWarning, match=r"log\.csv: .*not UTF-8.*Windows-1252.*source: \{encoding: "):
        rec = read_recording(path)
    assert list(rec.channels) == ["q.Größe"]
    assert "Windows-1252" in rec.meta["notes"][0]


@pytest.mark.parametrize("name", ["klingon", "base64", 3])
def test_an_unknown_encoding_is_named(name: object) -> None:
    """With examples of what would be right."""
    content = {"flexdyn_map": 1, "source": {"encoding": name}, "channels": {"q.a": "x"}}
    with pytest.raises(InputError, match=r"source\.encoding: "):
        ChannelMap.from_dict(content)


@pytest.mark.parametrize(
    ("first", "second"),
    [
        ("2024-05-03T12:00:00", "2024-05-03T12:00:00.25"),
        ("2024-05-03 23:59:59.900000001", "2024-05-04 00:00:00.150000001"),
        ("2024-05-03T12:00:00+02:00", "2024-05-03T10:00:00.250Z"),
        ('"2024-05-03 12:00:00.1"', '"2024-05-03 12:00:00.35"'),
        ("03.05.2024 12:00:00.5", "03.05.2024 12:00:00.75"),
    ],
)
def test_dates_are_counted_from_the_first(tmp_path: Path, first: str, second: str) -> None:
    """ISO 8601 with T or space, with a zone or not, and days before months; exact to the nanosecond."""
    rec = read_recording(saved(tmp_path, f"t,q.a\n{first},1\n{second},2\n"))
    assert rec.same_as(Recording([0.0, 0.25], {"q.a": [1.0, 2.0]}))


def test_dates_of_pandas_as_a_column_or_as_the_index(tmp_path: Path) -> None:
    """The start is kept as nanoseconds since 1970; a bag of it has the stamps that the table had."""
    start = datetime(2024, 5, 3, 12, tzinfo=timezone(timedelta(hours=2)))
    frame = pd.DataFrame({"t": pd.date_range(start, periods=4, freq="2ms"), "q.a": T})
    frame.to_csv(tmp_path / "column.csv", index=False)
    frame.set_index("t").rename_axis(None).to_csv(tmp_path / "index.csv")
    for name in ("column.csv", "index.csv"):
        rec = read_recording(tmp_path / name)
        assert rec.same_as(Recording([0.0, 0.002, 0.004, 0.006], {"q.a": T}))
        assert rec.meta["start_ns"] == int(start.timestamp()) * 10**9


def test_a_row_without_a_date_is_named(tmp_path: Path) -> None:
    """With the line and the column."""
    with pytest.raises(InputError, match=r"t: line 3: no date and time of day, got '5'"):
        read_recording(saved(tmp_path, "t,q.a\n2024-05-03T12:00:00,1\n5,2\n"))
    with pytest.raises(InputError, match=r"q\.a: line 3: not a number, got 'x'"):
        read_recording(saved(tmp_path, "t,q.a\n2024-05-03T12:00:00,1\n2024-05-03T12:00:01,x\n"))


def test_units_behind_the_names_hold(tmp_path: Path) -> None:
    """SI is read without a map; degrees are refused without one, and converted by one that says nothing of units."""
    rec = read_recording(saved(tmp_path, "t [s],q.a [rad],v.a (rad/s),q.lift [m]\n0,1,2,3\n1,2,3,4\n"))
    assert list(rec.channels) == ["q.a", "v.a", "q.lift"]
    assert rec.unit("q.lift") == "m"
    path = saved(tmp_path, "t [ms],q.a [°],n [U/min]\n0,180,60\n500,90,30\n")
    with pytest.raises(InputError, match=r"the unit is not SI, got 'ms'"):
        read_recording(path)
    for names in ({"q.a": "q.a", "v.a": "n"}, {"q.a": "q.a [°]", "v.a": "n [U/min]"}):
        mapped = read_recording(path, map=ChannelMap.from_dict({"flexdyn_map": 1, "channels": names}))
        np.testing.assert_array_equal(mapped.t, [0.0, 0.5])
        np.testing.assert_allclose(mapped["q.a"], [np.pi, np.pi / 2], rtol=1e-15)
        np.testing.assert_allclose(mapped["v.a"], [2 * np.pi, np.pi], rtol=1e-15)


def test_brackets_that_are_no_unit_stay_in_the_name(tmp_path: Path) -> None:
    """Counted columns of other loggers, and joints called so."""
    rec = read_recording(saved(tmp_path, "t,q.a[1],position[0],note (x)\n0,1,2,3\n1,2,3,4\n"))
    assert list(rec.channels) == ["q.a[1]", "position[0]", "note (x)"]


def test_a_unit_that_the_map_contradicts_is_named(tmp_path: Path) -> None:
    """The file says rpm, the map degrees per second."""
    path = saved(tmp_path, "t,n [rpm]\n0,1\n1,2\n")
    wrong = ChannelMap.from_dict({"flexdyn_map": 1, "channels": {"v.a": {"from": "n", "unit": "deg/s"}}})
    with pytest.raises(InputError, match=r"channels\.v\.a\.unit: not the unit that the file states.*'rpm'"):
        read_recording(path, map=wrong)


def test_others_kept_beside_a_name_without_its_unit(tmp_path: Path) -> None:
    """What the map calls by its bare name is not kept a second time."""
    content = {"flexdyn_map": 1, "time": "Zeit", "channels": {"q.a": "Ist"}, "others": "keep"}
    path = saved(tmp_path, "Zeit [s],Ist [°],Druck [bar]\n0,180,1\n1,90,2\n")
    rec = read_recording(path, map=ChannelMap.from_dict(content))
    assert list(rec.channels) == ["q.a", "Druck [bar]"]
    assert rec.unit("Druck [bar]") == "bar"


def test_a_german_file_in_two_tries(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """The first try's answer is a map to be copied; with the joint's name in it, the second one plots."""
    path = saved(tmp_path, GERMAN.split("\n", 1)[1], "latin-1")
    picture = tmp_path / "out.png"
    assert main(["plot", str(path), "-o", str(picture)]) == 2
    told = capsys.readouterr().err
    found = re.search(r"such as (\{flexdyn_map: 1.*\})", told)
    assert found is not None
    expected = "{flexdyn_map: 1, time: Zeit, channels: {q.JOINT: Ist, tau.JOINT: Moment}, repair: [fill_nan]}"
    assert found[1] == expected
    (tmp_path / "drop.yaml").write_text(
        found[1].replace("JOINT", "elbow").replace("fill_nan", "drop_nan"), encoding="utf-8"
    )
    with pytest.warns(RecordingWarning, match="comma|1252"):
        rec = read_recording(path, map=tmp_path / "drop.yaml")
    np.testing.assert_array_equal(rec.t, [0.0, 0.002])
    np.testing.assert_allclose(rec["q.elbow"], np.deg2rad([9.5, 10.0]), rtol=1e-15)
    np.testing.assert_array_equal(rec["tau.elbow"], [1.25, -1.5])
    (tmp_path / "map.yaml").write_text(found[1].replace("JOINT", "elbow"), encoding="utf-8")
    assert main(["plot", str(path), "--map", str(tmp_path / "map.yaml"), "-o", str(picture)]) == 0
    told = capsys.readouterr().err
    assert "decimal comma" in told
    assert "Windows-1252" in told
    assert picture.exists()


def test_a_line_of_a_spreadsheet_before_the_names(tmp_path: Path) -> None:
    """Empty rows of separators are skipped; a line of text is told by its number."""
    blank = saved(tmp_path, ";;\nt;q.a;q.b\n0;1;2\n1;2;3\n")
    assert fd.read_recording(blank).same_as(Recording([0, 1], {"q.a": [1, 2], "q.b": [2, 3]}))
    told = {"flexdyn_map": 1, "source": {"names_line": 2}, "time": "Zeit", "channels": {"q.a": "Ist"}}
    with pytest.warns(RecordingWarning, match="decimal comma"):
        rec = read_recording(saved(tmp_path, GERMAN), map=ChannelMap.from_dict(told))
    np.testing.assert_allclose(rec["q.a"], np.deg2rad([9.5, 9.75, 10.0]), rtol=1e-15)


def test_a_suggested_map_numbers_the_joints_and_repairs_what_is_suggested() -> None:
    """One joint a column; empty cells of other columns are no reason for a repair; a joint may be called second."""
    names = ["Zeit", "Soll A1", "Ist A1 [°]", "Ist A2 [°]", "Kraft [N]"]
    expected = "{flexdyn_map: 1, time: Zeit, channels: {q.JOINT1: Ist A1, q.JOINT2: Ist A2, tau.JOINT: Kraft}"
    assert suggested_map(names, {"Soll A1"}) == f"{expected}}}"
    assert suggested_map(names, {"Ist A2 [°]"}) == f"{expected}, repair: [fill_nan]}}"
    assert suggested_map(["q.second", "tau.second"]).startswith("{flexdyn_map: 1, time: {rate: HERTZ}, ")


def test_columns_of_arrays() -> None:
    """Rows or columns of a matrix, whichever has the samples; what is no signal over time is left out."""
    shapes = {
        "a.time": (1, 50),
        "a.pos": (50, 2),
        "a.trq": (2, 50),
        "a.gain": (2, 2),
        "a.many": (50, 40),
        "a.n": (1, 1),
    }
    found = columns_of_arrays(shapes)
    assert found == ["a.time", "a.pos(:,1)", "a.pos(:,2)", "a.trq(1,:)", "a.trq(2,:)"]
    assert 'tau.JOINT2: "a.trq(2,:)"' in suggested_map(found)
    assert columns_of_arrays({}) == []
