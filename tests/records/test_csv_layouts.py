"""CSV as laboratories, pandas, NumPy and Excel write it."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest

from flexdyn.errors import InputError
from flexdyn.records import Recording, read_recording, write_recording
from flexdyn.records.csv import file as csv_file
from flexdyn.records.request import Layout, Request
from flexdyn.records.table import Table

T = np.array([0.0, 0.1, 0.2])

DRIVE = """\
Date:;2020-07-08 21:54:05\r
Scale:;0;True;100.000\r
"Trigger:;0;0.000000;""Parameter values"";""Rising above value"\"\"\r
;Velocity actual value averaged;Torque actual value averaged\r
ms;rpm;%\r
0.000;0;0.5\r
40.000;-20;1.5\r
"""


def saved(folder: Path, text: str, encoding: str = "utf-8") -> Path:
    """The text as a file."""
    path = folder / "log.csv"
    path.write_bytes(text.encode(encoding))
    return path


def asked(path: Path, *columns: str | int, **layout: Any) -> Table:
    """The columns of a file laid out like that."""
    return csv_file.read(path, Request(columns=frozenset(columns), layout=Layout(**layout), mapped=True))


def test_a_drive_s_export(tmp_path: Path) -> None:
    """Lines of settings before the names, a line of units after them, a first column without a name."""
    path = saved(tmp_path, DRIVE)
    table = asked(path, 1, "Velocity actual value averaged", 3, names_line=4, first_line=6)
    assert set(table.columns) == {"column 1", "column 3", "Velocity actual value averaged"}
    np.testing.assert_array_equal(table.columns["column 1"], [0.0, 40.0])
    np.testing.assert_array_equal(table.columns["Velocity actual value averaged"], [0.0, -20.0])
    np.testing.assert_array_equal(table.columns["column 3"], [0.5, 1.5])
    assert table.rows.first == 6
    by_units = asked(path, "ms", "%", first_line=6)
    np.testing.assert_array_equal(by_units.columns["ms"], [0.0, 40.0])


@pytest.mark.parametrize("index", [True, False])
def test_pandas(tmp_path: Path, index: bool) -> None:
    """The labels of rows that pandas puts first are no channel; every double comes back."""
    values = np.random.default_rng(5).normal(size=3)
    pd.DataFrame({"t": T, "q.a": values, "tau.a": [1, 2, 3]}).to_csv(tmp_path / "log.csv", index=index)
    assert read_recording(tmp_path / "log.csv") == Recording(T, {"q.a": values, "tau.a": [1, 2, 3]})


def test_labels_of_rows_may_be_text(tmp_path: Path) -> None:
    """They are not read."""
    pd.DataFrame({"t": T, "q.a": T}, index=["x", "y", "z"]).to_csv(tmp_path / "log.csv")
    assert read_recording(tmp_path / "log.csv") == Recording(T, {"q.a": T})


@pytest.mark.parametrize("delimiter", [" ", ",", ";", "\t"])
@pytest.mark.parametrize("comments", ["# ", ""])
def test_numpy_savetxt(tmp_path: Path, delimiter: str, comments: str) -> None:
    """With any separator, white space included, and the header behind a # or not."""
    data = np.column_stack([T, np.random.default_rng(6).normal(size=(3, 2))])
    header = delimiter.join(["t", "q.a", "q.b"])
    np.savetxt(tmp_path / "log.txt", data, delimiter=delimiter, header=header, comments=comments, fmt="%25.17g")
    assert read_recording(tmp_path / "log.txt") == Recording(T, {"q.a": data[:, 1], "q.b": data[:, 2]})


def test_numbers_without_a_header(tmp_path: Path) -> None:
    """Columns are then asked for by number, from 1."""
    np.savetxt(tmp_path / "log.csv", np.column_stack([T, 2 * T, 3 * T]))
    table = asked(tmp_path / "log.csv", 1, 3)
    np.testing.assert_array_equal(table.columns["column 3"], 3 * T)
    assert table.rows.first == 1


@pytest.mark.parametrize("quote", ["", '"'])
@pytest.mark.parametrize("names", ["Zeit [s];Winkel, links;Bemerkung", '"Zeit [s]";"Winkel, links";"Bemerkung"'])
def test_excel_in_german(tmp_path: Path, names: str, quote: str) -> None:
    """Byte-order mark, semicolons, decimal commas, text with a semicolon in quotes, CRLF."""
    rows = f'{quote}0,0{quote};{quote}-1,5E-3{quote};"a; b"\r\n{quote}0,25{quote};1.5;\r\n'
    path = saved(tmp_path, f"{names}\r\n{rows}", "utf-8-sig")
    table = asked(path, "Zeit [s]", "Winkel, links", decimal=",")
    np.testing.assert_array_equal(table.columns["Zeit [s]"], [0.0, 0.25])
    np.testing.assert_array_equal(table.columns["Winkel, links"], [-1.5e-3, 1.5])


def test_quoted_cells(tmp_path: Path) -> None:
    """Quotes round names and numbers make no difference."""
    path = saved(tmp_path, '"t", "q.a" ,"tau.a"\n"0","1.5","2"\n"0.5",2.5,-3\n')
    assert read_recording(path) == Recording([0.0, 0.5], {"q.a": [1.5, 2.5], "tau.a": [2.0, -3.0]})


@pytest.mark.parametrize("encoding", ["utf-16", "utf-16-be"])
def test_unicode_text(tmp_path: Path, encoding: str) -> None:
    """Excel's Unicode text has two bytes a letter; what is cut there is no number."""
    mark = "\ufeff" if encoding == "utf-16-be" else ""
    path = saved(tmp_path, f"{mark}t\tq.\u03b1\r\n0\t1.5\r\n1\t-2\r\n", encoding)
    assert read_recording(path) == Recording([0.0, 1.0], {"q.\u03b1": [1.5, -2.0]})
    path.write_bytes(path.read_bytes()[:-5])
    with pytest.raises(InputError, match="line 3: "):
        read_recording(path)


def test_names_with_quotes_come_back(tmp_path: Path) -> None:
    """What is written quoted is read unquoted."""
    rec = Recording(T, {'"a"': T, 'a"b': 2 * T, '"': 3 * T, "a;b": T, "#x": T, "a b": T})
    for suffix in (".csv", ".tsv", ".txt"):
        write_recording(rec, tmp_path / f"log{suffix}")
        assert read_recording(tmp_path / f"log{suffix}") == rec


def test_tabs(tmp_path: Path) -> None:
    """A .tsv file has tabs."""
    write_recording(Recording(T, {"q.a": T}), tmp_path / "log.tsv")
    assert (tmp_path / "log.tsv").read_text().startswith("t\tq.a\n0.0\t0.0\n")


def test_a_wanted_column_is_read_beside_any_text(tmp_path: Path) -> None:
    """Only what is asked for must be numbers; every row must have its cells all the same."""
    path = saved(tmp_path, "time,mode,pos\n0,on,1\n1,,2\n")
    np.testing.assert_array_equal(asked(path, "pos").columns["pos"], [1.0, 2.0])
    path = saved(tmp_path, "time,mode,pos\n0,on,1\n1,off\n2,on,3,4\n")
    with pytest.raises(InputError, match="line 3: 2 cells where the first has 3"):
        asked(path, "time")


@pytest.mark.parametrize(
    ("text", "columns", "layout", "words"),
    [
        ("time,pos\n0,1\n1,2\n", ("tme",), {}, "tme: line 1: no such column; did you mean 'time'"),
        ("time,pos\n0,1\n1,2\n", (3,), {}, "column 3: line 1: no such column; there are 2"),
        ("time,pos\n0,1\n1,2\n", (0,), {}, "column 0: line 1: no such column"),
        ("a,pos,pos\n0,1,2\n", ("pos",), {}, "several columns have the name; give the number of one: 2 and 3"),
        ("x\n\ntime,pos\n0,1\n1,?\n", (2,), {"names_line": 3}, r"column 2: line 5: not a number, got '\?'"),
        ("time;pos\n0;1,5\n1;1,x\n", ("pos",), {"decimal": ","}, "pos: line 3: not a number, got '1,x'; .*comma"),
        (
            "time;pos\n0;1,5\n1;2.5\n",
            ("pos",),
            {},
            "pos: line 2: not a number, got '1,5'; .*say decimal: ','",
        ),
        ("time,pos\n0,1\n", ("pos",), {"first_line": 9}, "the file ends before line 9"),
        ("time,pos\n0,1\n", ("pos",), {"first_line": 2, "names_line": 2}, "samples is not below the names"),
    ],
)
def test_what_is_not_there_is_named(
    tmp_path: Path, text: str, columns: tuple[str | int, ...], layout: dict[str, Any], words: str
) -> None:
    """One line with the column as it was asked for, and the line of the file."""
    with pytest.raises(InputError, match=words):
        asked(saved(tmp_path, text), *columns, **layout)


def test_progress_grows_to_the_whole(tmp_path: Path) -> None:
    """A long file says how far it is; the last word is everything."""
    rec = Recording(np.arange(200_000) * 1e-3, {"q.a": np.random.default_rng(7).normal(size=200_000)})
    write_recording(rec, tmp_path / "log.csv")
    shares: list[float] = []
    assert read_recording(tmp_path / "log.csv", progress=shares.append) == rec
    assert len(shares) > 3
    assert shares == sorted(shares)
    assert shares[-1] == 1.0
