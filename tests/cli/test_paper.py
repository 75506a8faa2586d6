"""flexdyn paper: how the study's outcome is told; the study itself is tested where it lives."""

from __future__ import annotations

import sys
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest

from tests.cli.conftest import Runner


@dataclass(frozen=True)
class Check:
    """A named number with its bound."""

    name: str
    value: float
    bound: float
    passed: bool


@dataclass(frozen=True)
class Study:
    """What a study hands back."""

    summary: dict[str, Any]
    checks: list[Check]


@pytest.fixture
def study(monkeypatch: pytest.MonkeyPatch) -> Callable[..., list[Path]]:
    """Put a study with given checks in the place of the real one, which takes its time."""

    def _study(*passed: bool) -> list[Path]:
        folders: list[Path] = []

        def run_study(out: Path, *, progress: Callable[[str], None] | None = None) -> Study:
            folders.append(out)
            assert progress is None, "stderr is no terminal here"
            checks = [Check(f"check {k}", 1e-12, 1e-11, good) for k, good in enumerate(passed)]
            return Study({"slope": -1.0, "worst": float("inf")}, checks)

        module = ModuleType("flexdyn.paper")
        module.run_study = run_study  # type: ignore[attr-defined]
        monkeypatch.setitem(sys.modules, "flexdyn.paper", module)
        return folders

    return _study


def test_checks_that_pass_are_exit_code_0(flexdyn: Runner, study: Callable[..., list[Path]]) -> None:
    """A table of checks, and where the files are; the folder has a default."""
    folders = study(True, True)
    outcome = flexdyn("paper")
    assert (outcome.code, outcome.err) == (0, "")
    assert folders == [Path("flexdyn_paper")]
    assert outcome.out.count("passed") == 2
    assert "check 1" in outcome.out
    assert "flexdyn_paper" in outcome.out


def test_a_check_that_fails_is_exit_code_1(flexdyn: Runner, study: Callable[..., list[Path]]) -> None:
    """Said in the table and to the shell."""
    folders = study(True, False)
    outcome = flexdyn("paper", "-o", "there/study")
    assert outcome.code == 1
    assert folders == [Path("there/study")]
    assert outcome.out.count("FAILED") == 1


def test_json_is_the_summary(flexdyn: Runner, study: Callable[..., list[Path]]) -> None:
    """Pure JSON, infinite numbers null."""
    study(True)
    assert flexdyn("paper", "--json").json == {"slope": -1.0, "worst": None}
