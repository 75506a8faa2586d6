"""flexdyn paper: how the study's outcome is told; the study itself is tested where it lives."""

from __future__ import annotations

import sys
from collections.abc import Callable
from pathlib import Path
from types import ModuleType

import pytest

from flexdyn.paper import Check, PaperStudy, hidden_friction
from tests.cli.conftest import Runner

FOUND = {
    "hidden": [
        {
            **{"effect": "stribeck_friction", "joint": "elbow", "side": "link", "parameter": "excess", "unit": "N m"},
            **{"true": 0.01, "found": 0.01021, "std": 0.001},
        },
        {
            **{"effect": "coulomb_friction", "joint": "shoulder", "side": "link", "parameter": "level", "unit": "N m"},
            **{"true": 0.02, "found": None, "std": None},
        },
    ],
    "gap": [{"name": "as given", "gap": 1234.0}, {"name": "noise alone", "gap": 1.0}],
}


@pytest.fixture
def study(monkeypatch: pytest.MonkeyPatch) -> Callable[..., list[Path]]:
    """Put a study with given checks in the place of the real one, which takes its time."""

    def _study(*passed: bool) -> list[Path]:
        folders: list[Path] = []

        def run_paper_study(out: Path, *, diagnose: bool, progress: Callable[[str], None] | None = None) -> PaperStudy:
            folders.append(out / "diagnosis" if diagnose else out)
            assert progress is None, "stderr is no terminal here"
            checks = tuple(Check(f"check {k}", 1e-12, 1e-11, good, "m") for k, good in enumerate(passed))
            numbers = {hidden_friction.CHAPTER_TITLE: FOUND} if diagnose else {}
            return PaperStudy({"slope": -1.0, "worst": float("inf"), "numbers": numbers}, checks, ())

        module = ModuleType("flexdyn.paper")
        module.run_paper_study = run_paper_study  # type: ignore[attr-defined]
        module.hidden_friction = hidden_friction  # type: ignore[attr-defined]
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
    assert flexdyn("paper", "--json").json == {"slope": -1.0, "worst": None, "numbers": {}}


def test_what_was_hidden_and_found_is_told(flexdyn: Runner, study: Callable[..., list[Path]]) -> None:
    """True and found numbers side by side, what was not found, the gap from step to step, the report's place."""
    folders = study(True, False)
    outcome = flexdyn("paper", "--diagnose", "-o", "there")
    assert outcome.code == 1, "a check failed"
    assert folders == [Path("there/diagnosis")]
    told = " ".join(outcome.out.replace("│", " ").split())
    assert "Stribeck friction on the link side of elbow excess 0.01 0.0102 [0.0083, 0.0122] N m" in told
    assert "Coulomb friction on the link side of shoulder level 0.02 not found" in told
    assert "as given 1234" in told
    assert "there/diagnosis/report.html" in told
