"""Tables of the command line in narrow terminals: names and numbers stay whole, and every symbol is explained."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import flexdyn as fd
from flexdyn.cli.diagnosis_text import diagnosis_text
from flexdyn.cli.output import table
from flexdyn.cli.sheet import Sheet
from flexdyn.diagnose.report.result import Diagnosis
from tests.cli.conftest import Runner
from tests.diagnose import report_cases as cases

WORD = st.text("abcdefghij_0123456789.", min_size=1, max_size=12)
CELL = st.lists(WORD, min_size=1, max_size=6).map(" ".join)


@settings(max_examples=150, deadline=None)
@given(
    rows=st.integers(1, 6).flatmap(lambda n: st.lists(st.lists(CELL, min_size=n, max_size=n), min_size=1, max_size=5)),
    numbers=st.sets(st.integers(0, 5)),
    width=st.integers(40, 120),
)
def test_every_word_stays_whole_and_no_line_is_too_long(rows: list[list[str]], numbers: set[int], width: int) -> None:
    """Whatever is in the cells: words of at most twelve letters fit into forty columns."""
    heads = [f"head{k}" for k in range(len(rows[0]))]
    right = [heads[k] for k in numbers if 0 < k < len(heads) and all(len(row[k]) <= 12 for row in rows)]
    lines = table("Title", heads, rows, right=right, legend={"x": "what it is"}).lines(width)
    assert max(map(len, lines)) <= width
    said = " ".join(lines).split()
    for row in rows:
        for cell in row:
            assert all(word in said for word in cell.split())
    for k, head in enumerate(heads):
        for row in rows if head in right else ():
            assert any(row[k] in line for line in lines), "a number is never broken, not even at its blanks"


def test_a_wide_table_has_its_names_on_lines_of_their_own() -> None:
    """First between words, then the names above, then cell after cell."""
    made = Sheet("Drives", ("joint", "J", "K"), (("shoulder_lift_joint", "1.7", "25000.0"),), frozenset({"J", "K"}))
    rule = "\N{BOX DRAWINGS LIGHT HORIZONTAL}"
    assert made.lines(80)[2:5] == [
        "joint                  J        K",
        rule * 33,
        "shoulder_lift_joint  1.7  25000.0",
    ]
    assert made.lines(22)[2:6] == ["    J        K", f"  {rule * 12}", "shoulder_lift_joint", "  1.7  25000.0"]
    assert made.lines(13)[2:5] == ["shoulder_lift_joint", "  J 1.7", "  K 25000.0"]


TABLED = (cases.explained, cases.partly, cases.not_converged, cases.interrupted, cases.robot)
"""Diagnoses that the terminal shows in tables."""


@pytest.mark.parametrize("made", TABLED)
def test_a_diagnosis_fits_eighty_columns(made: Callable[[], Diagnosis], tmp_path: Path) -> None:
    """Tables of six joints with long names, and of a finding with three names."""
    sheets = [part for part in diagnosis_text(made(), tmp_path) if isinstance(part, Sheet)]
    assert sheets
    for sheet in sheets:
        lines = sheet.lines(80)
        assert max(map(len, lines)) <= 80
        words = " ".join(lines).split()
        for row in sheet.rows:
            assert all(word in words for cell in row for word in cell.split())


def test_tables_of_other_commands_fit_eighty_columns(flexdyn: Runner, monkeypatch: pytest.MonkeyPatch) -> None:
    """A robot with long names of joints; its symbols are explained below."""
    monkeypatch.setenv("COLUMNS", "80")
    fd.simulate(fd.load_model("ur5"), duration=0.1).save("a.h5")
    for command in (("info", "ur5"), ("info", "ur5", "--modes"), ("effects",), ("compare", "a.h5", "a.h5")):
        outcome = flexdyn(*command)
        assert outcome.code == 0
        for line in outcome.out.splitlines():
            assert len(line) <= 80 or "  " not in line.strip(), line
        if "ur5" in command:
            assert outcome.out.count("shoulder_lift_joint") >= 3
            assert "M_ii: inertia of the arm about the joint" in " ".join(outcome.out.split())
