"""The page of limits lists every fault that is tried, on what, and what is lost by it."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any

from tests.batch import test_dask as dask
from tests.batch import test_interruptions as interrupted
from tests.batch import test_resume as resumed
from tests.faults import test_killed as killed
from tests.faults import test_refused as refused
from tests.simulation import test_threads as threads

PAGE = Path(__file__).parents[1] / "docs" / "limits.md"
WORDS = {"run": "a run", "model": "a model", "plot": "pictures", "report": "a report"}
"""What the names of the writers stand for; those of recordings are suffixes."""
ONE_LINE = "nothing: one line; the old file stays to the last byte"
STORE = "a study's store"


def listed(names: Iterable[str]) -> str:
    """Suffixes of recordings, and what else is written."""
    parts = [name.partition(".") for name in names]
    suffixes = " ".join(f"`.{suffix}`" for word, _, suffix in parts if not word)
    return ", ".join([f"recordings ({suffixes})", *dict.fromkeys(WORDS[word] for word, _, _ in parts if word)])


ROWS: tuple[tuple[str, str, str, Callable[..., Any]], ...] = (
    ("a file may not grow", listed(refused.NAMES), ONE_LINE, refused.test_a_file_that_may_not_grow),
    ("a full disk", listed(refused.NAMES), ONE_LINE, refused.test_a_disk_that_is_full),
    ("a read-only disk or folder", listed(refused.NAMES), ONE_LINE, refused.test_a_read_only_folder),
    (
        "kill -9 before every step of a save",
        listed(killed.ALL_NAMES),
        "nothing: each file is the old one or the new one",
        killed.test_killed_while_it_saves,
    ),
    (
        "kill -9 before every step of writing",
        "`flexdyn diagnose -o`",
        "the diagnosis; each file is the old one or the new one",
        killed.test_a_diagnosis_killed_while_it_writes,
    ),
    (
        f"kill -9 at {interrupted.KILLS} random moments",
        STORE,
        "chunks in progress; after `--resume` nothing",
        interrupted.test_kill_at_any_moment,
    ),
    ("a full disk", STORE, "chunks in progress; after `--resume` nothing", interrupted.test_a_full_disk),
    ("a read-only folder", STORE, "nothing: one line", interrupted.test_a_read_only_folder),
    (
        "a damaged piece of an array",
        STORE,
        "its chunk; after `--resume` nothing",
        resumed.test_a_damaged_piece_is_done_again,
    ),
    (
        "damaged metadata of an array",
        STORE,
        "nothing: `--resume` makes them again",
        resumed.test_damaged_metadata_and_coordinates,
    ),
    ("another version of flexdyn", STORE, "nothing: one line", resumed.test_a_store_of_another_version),
    ("another version of the format", STORE, "nothing: one line", resumed.test_a_store_of_another_format),
    ("a Dask worker is killed", STORE, "nothing: another does its chunks", dask.test_a_worker_is_killed_in_the_middle),
    (
        "the Dask scheduler is killed",
        STORE,
        "chunks in progress; after `--resume` nothing",
        dask.test_a_scheduler_that_vanishes,
    ),
    ("Ctrl-C", STORE, "chunks in progress; after `--resume` nothing", interrupted.test_control_c),
    (
        "Ctrl-C",
        f"a simulation ({', '.join(threads.ENDLESS)})",
        "the run; it ends at once",
        threads.test_ctrl_c_stops_a_simulation,
    ),
)
"""Fault, what it is tried on, what is lost, and the test that tries it."""


def as_markdown() -> str:
    """The table as it stands in the page."""
    lines = ["| fault | tried on | what is lost | test |", "| --- | --- | --- | --- |"]
    for fault, what, lost, test in ROWS:
        file = Path(test.__code__.co_filename).relative_to(PAGE.parents[1]).as_posix()
        lines.append(f"| {fault} | {what} | {lost} | `{test.__name__}` in `{file}` |")
    return "\n".join(lines)


def test_the_page_holds_the_table() -> None:
    """A fault whose test or list of files changes without its row fails here, with the right table to copy."""
    assert as_markdown() in PAGE.read_text(encoding="utf-8"), as_markdown()
