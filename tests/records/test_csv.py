"""CSV: tables by other hands are read, damaged ones are answered with line and channel."""

from __future__ import annotations

import tracemalloc
from pathlib import Path

import numpy as np
import pytest

from flexdyn.errors import InputError
from flexdyn.records import Recording, read_recording, write_recording


def saved(folder: Path, text: str | bytes) -> Path:
    """The text as a file."""
    path = folder / "log.csv"
    path.write_bytes(text if isinstance(text, bytes) else text.encode())
    return path


@pytest.mark.parametrize(
    "text",
    [
        "t,q.a,tau.a\n0,1,-2\n0.5,3e-1,4\n",
        "t,q.a,tau.a\n0,1,-2\n0.5,3e-1,4",
        "\ufefft,q.a,tau.a\r\n0,1,-2\r\n0.5,0.3,4\r\n",
        "t, q.a , tau.a\n 0 , 1, -2 \n0.5,+.3,4.\n",
        "t;q.a;tau.a\n0;1;-2\n0.5;0.3;4\n\n  \n\n",
        "t\tq.a\ttau.a\n0\t1\t-2\n0.5\t0.3\t4\n",
        "# by hand, a; b\n\n  # more, text\nt,q.a,tau.a\n0,1,-2\n0.5,0.3,4\n",
        "t,q.a,tau.a\r0,1,-2\r0.5,0.3,4\r",
    ],
)
def test_tables_by_other_hands(tmp_path: Path, text: str) -> None:
    """Delimiters, line ends, spaces, comments, byte-order mark and blank lines at the end make no difference."""
    rec = read_recording(saved(tmp_path, text))
    assert rec.same_as(Recording([0.0, 0.5], {"q.a": [1.0, 0.3], "tau.a": [-2.0, 4.0]}))
    assert rec.name == "log"
    assert rec.meta == {}


def test_columns_keep_their_order_wherever_t_stands(tmp_path: Path) -> None:
    """The column of time need not come first."""
    rec = read_recording(saved(tmp_path, "tau.b;t;q.a\n1;0;2\n1;1;2\n"), name="mine")
    assert list(rec.channels) == ["tau.b", "q.a"]
    np.testing.assert_array_equal(rec.t, [0.0, 1.0])
    assert rec.name == "mine"


@pytest.mark.parametrize("comments", ["# ", ""])
def test_numpy_savetxt(tmp_path: Path, comments: str) -> None:
    """The header of savetxt stands behind a # unless told not to."""
    data = np.column_stack([np.arange(50.0), np.random.default_rng(1).normal(size=(50, 2))])
    path = tmp_path / "log.csv"
    np.savetxt(path, data, delimiter=",", header="t,q.a,q.b", comments=comments, fmt="%.17g")
    rec = read_recording(path)
    assert rec.same_as(Recording(data[:, 0], {"q.a": data[:, 1], "q.b": data[:, 2]}))


def test_what_is_written_is_the_plain_table_of_the_contract(tmp_path: Path) -> None:
    """Header of channel names, shortest digits, newlines; meta is dropped."""
    path = tmp_path / "log.csv"
    write_recording(Recording([0.0, 0.1], {"q.a": [1 / 3, -0.0], "tau.a": [5e-324, 1e22]}, meta={"a": 1}), path)
    assert path.read_bytes() == b"t,q.a,tau.a\n0.0,0.3333333333333333,5e-324\n0.1,-0.0,1e+22\n"


@pytest.mark.parametrize(
    ("text", "row", "channel", "words"),
    [
        ("t,q.a\n0,1\n1,x\n2,3\n", 3, "q.a", "not a number, got 'x'"),
        ("# a\n# b\nt,q.a,q.b\n0,1,2\n1,,2\n", 5, "q.a", "not a finite number, got nan; .*empty cell"),
        ("t,q.a\n0,1\n ,1\n", 3, "t", "not a finite number, got nan; .*empty cell"),
        ("t,q.a,q.b\n0,1,2\n1,2\n2,2,2\n", 3, "q.b", "2 cells where the header names 3"),
        ("t,q.a\n0,1\n1,2,3\n", 3, None, "3 cells where the header names 2"),
        ("t,q.a\n0,1\n\n1,2\n", 3, None, "empty line between samples"),
        ("t,q.a\n0,1\n  \n1,2\n", 3, None, "empty line between samples"),
        ("t,q.a\n0,1\n1,nan\n", 3, "q.a", "not a finite number, got nan"),
        ("t,q.a\n0,1\n1,1e999\n", 3, "q.a", "not a finite number, got inf"),
        ("\n# x\nt,q.a\n0,1\n2,2\n1,2\n", 6, "t", "time runs backwards, from 2.0 s, got 1.0"),
        ("t,q.a\n0,1\n0,2\n", 3, "t", "two samples at one time"),
        ("t;q.a\n0;1,5\n1;2.5\n", 2, "q.a", "not a number, got '1,5'"),
        ("t,q.a\n0,1_0\n1,2\n", 2, "q.a", "not a number"),
        ("t,q.a\n0,\u0663\n1,2\n", 2, "q.a", "not a number"),
        ("t,q.a,q.a\n0,1,2\n1,2,3\n", 1, "q.a", "the channel is there twice"),
        ("t,q.a,t\n0,1,2\n1,2,3\n", 1, "t", "the channel is there twice"),
        ("t,q.a,\n0,1,2\n1,2,3\n", 1, "", "the channel has no name"),
        ("# x\ntime,q.a\n0,1\n1,2\n", 2, "t", "no column t; did you mean 'time'"),
        ("q.a,time [s]\n0,1\n1,2\n", 1, "t", "no column t; did you mean 'time \\[s\\]'"),
        ("0,1\n1,2\n", 1, None, "no header"),
        (b"t,q.a\n0,1\n1,\xff2\n", 3, "q.a", "not a number"),
    ],
)
def test_damage_is_named_with_line_and_channel(
    tmp_path: Path, text: str | bytes, row: int, channel: str | None, words: str
) -> None:
    """Lines count from 1 in the file as an editor shows it, header and comments included."""
    path = saved(tmp_path, text)
    with pytest.raises(InputError, match=f"line {row}: .*{words}") as caught:
        read_recording(path)
    assert (caught.value.row, caught.value.data.get("channel")) == (row, channel)
    assert str(caught.value).startswith(str(path))
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("", "the file is empty"),
        ("\n\n# only a comment\n", "the file is empty"),
        ("t,q.a\n", "0 samples are too few"),
        ("t,q.a\n0,1\n", "1 samples are too few"),
        ("t\n0\n1\n", "no channel beside t"),
    ],
)
def test_too_little_is_said(tmp_path: Path, text: str, words: str) -> None:
    """A file without samples is no recording."""
    with pytest.raises(InputError, match=words):
        read_recording(saved(tmp_path, text))


def test_damage_far_down_is_found_in_its_line(tmp_path: Path) -> None:
    """Lines are counted right across the blocks in which a long file is read."""
    rows = [f"{k},0.12345678901234567,{-k}" for k in range(100_000)]
    rows[87_654] = "87654,0.1,oops"
    path = saved(tmp_path, "t,q.a,q.b\n" + "\n".join(rows))
    with pytest.raises(InputError, match=r"q\.b: line 87656: not a number, got 'oops'"):
        read_recording(path)


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("blanks", [2, 3_000_000])
def test_rows_after_blank_lines_are_refused(tmp_path: Path, blanks: int) -> None:
    """Blank lines end the table; the first of them is named, however many follow."""
    path = saved(tmp_path, "t,q.a\n0,1\n1,2\n" + "\n" * blanks + "2,3\n")
    with pytest.raises(InputError, match="line 4: empty line between samples"):
        read_recording(path)


def test_endless_lines_are_refused(tmp_path: Path) -> None:
    """A file without newlines is not drawn into memory."""
    path = saved(tmp_path, b"t,q.a\n" + b"1" * 30_000_000)
    tracemalloc.start()
    try:
        with pytest.raises(InputError, match="line 2: longer than 1048576 characters"):
            read_recording(path)
        assert tracemalloc.get_traced_memory()[1] < 15e6
    finally:
        tracemalloc.stop()


@pytest.mark.parametrize("row", ["1," * 400_000, "x," * 400_000, "1," * 400_000 + "x"])
def test_hundreds_of_thousands_of_columns_do_not_hang(tmp_path: Path, row: str) -> None:
    """Hostile widths cost time in proportion, also where the bad cell must be found."""
    for text in (row, "t," + ",".join(f"c{k}" for k in range(100_000)) + "\n" + row[:200_001] + "\n"):
        with pytest.raises(InputError):
            read_recording(saved(tmp_path, text))


def test_memory_stays_below_three_times_the_numbers(tmp_path: Path) -> None:
    """50 MB of text are read with at most three times the doubles' size."""
    cells = "," + ",".join(repr(x) for x in np.random.default_rng(2).normal(size=60).tolist()) + "\n"
    samples = 42_000
    path = tmp_path / "log.csv"
    with open(path, "w") as stream:
        stream.write("t," + ",".join(f"q.j{k}" for k in range(60)) + "\n")
        stream.writelines(f"{k}{cells}" for k in range(samples))
    assert path.stat().st_size > 45e6
    tracemalloc.start()
    try:
        rec = read_recording(path)
        assert tracemalloc.get_traced_memory()[1] < 3 * samples * 61 * 8
    finally:
        tracemalloc.stop()
    assert len(rec) == samples
