"""What the process that starts the tests may have set, and tests must not feel; the order of the files; fixtures.

Tests of Ctrl-C need one: a shell has its background jobs, and all that they start, ignore it. And pytest-xdist tells
its workers how wide the terminal is, which is not where the output of a test goes. Libraries are installed without
bytecode: where Python may not write it either, each process that a test starts compiles all that it imports again.
"""

from __future__ import annotations

import gc
import os
import signal
import sys
from functools import cache
from pathlib import Path

import pytest

from tests.browser import one_browser

__all__ = ["one_browser"]

LONG = (
    *("discovery/test_diagnosis.py", "diagnose", "test_first_hour.py", "test_docs.py", "fuzz", "measured"),
    *("benchmarks", "batch", "cli", "viewer", "discovery"),
)
"""Folders and files that take long come first, so that no processor is left with a long file at the end.

The simulator of `discovery` is compiled by the first file that needs it; the others find what it compiled.
"""
HERE = Path(__file__).parent

if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
    signal.signal(signal.SIGINT, signal.default_int_handler)
os.environ.pop("COLUMNS", None)
os.environ.pop("PYTHONDONTWRITEBYTECODE", None)
sys.dont_write_bytecode = False


def pytest_configure(config: pytest.Config) -> None:
    """With `-n`, the tests of a file stay in one process, for they share what is dear to make; files in our order."""
    if config.getoption("dist", "no") == "load":
        config.option.dist = "loadfile"
    config.option.loadscopereorder = False


def pytest_collection(session: pytest.Session) -> None:
    """While thousands of tests are made, nothing becomes garbage."""
    gc.disable()


def pytest_collection_finish(session: pytest.Session) -> None:
    """They stay to the end: nobody looks through them for garbage again."""
    gc.freeze()
    gc.enable()


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Those of `LONG` first, in its order."""
    places = [HERE / name for name in LONG]
    assert all(place.exists() for place in places)

    @cache
    def place_of(path: Path) -> int:
        return next((k for k, place in enumerate(places) if path.is_relative_to(place)), len(places))

    items.sort(key=lambda item: place_of(item.path))
