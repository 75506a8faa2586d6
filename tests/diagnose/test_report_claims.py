"""Every sentence of report.html is true by report.json; a sentence that nobody can check does not stand there."""

from __future__ import annotations

import copy
import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from flexdyn.diagnose.report.result import Diagnosis
from tests.diagnose import report_cases as cases
from tests.diagnose.answers import dry_elbow
from tests.diagnose.report_reader import sentences, unchecked


def _read(diagnosis: Diagnosis, folder: Path) -> tuple[str, dict[str, Any]]:
    diagnosis.save(folder)
    html = (folder / "report.html").read_text(encoding="utf-8")
    return html, json.loads((folder / "report.json").read_text(encoding="utf-8"))


@pytest.mark.parametrize("made", [*cases.CASES, cases.robot, dry_elbow])
def test_every_sentence_is_borne_out(made: Callable[[], Diagnosis], tmp_path: Path) -> None:
    """All claims hold, and nothing is told beside claims, notes, and explanations that are the same on every page."""
    html, document = _read(made(), tmp_path)
    assert list(unchecked(html, document)) == []
    assert len(sentences(html)) > 5


def _all_probabilities(document: dict[str, Any]) -> None:
    for finding in document["findings"]:
        finding["probability"] -= 0.2


def _other_gap(document: dict[str, Any]) -> None:
    document["gap"]["test"]["after"] *= 1.1


def _a_better_rival(document: dict[str, Any]) -> None:
    document["structures"][-1]["log_evidence"] += 100.0


def _another_joint(document: dict[str, Any]) -> None:
    document["findings"][0]["joint"] = "shoulder"


def _another_share(document: dict[str, Any]) -> None:
    document["shares"]["noise"] += 0.01


def _moved_farther(document: dict[str, Any]) -> None:
    document["calibration"][0]["factor"] = 1.5


def _another_error(document: dict[str, Any]) -> None:
    document["errors"]["elbow"]["torque"]["before"] += 0.1


def _one_finding_less(document: dict[str, Any]) -> None:
    document["findings"].pop()


WRONG = (
    _all_probabilities,
    _other_gap,
    _a_better_rival,
    _another_joint,
    _another_share,
    _moved_farther,
    _another_error,
    _one_finding_less,
)


@pytest.mark.parametrize("change", WRONG)
def test_a_page_that_is_not_true_is_found_out(change: Callable[[dict[str, Any]], None], tmp_path: Path) -> None:
    """The numbers of report.json changed under the page: some claim does not hold any more."""
    html, document = _read(cases.explained(), tmp_path)
    wrong = copy.deepcopy(document)
    change(wrong)
    with pytest.raises((AssertionError, IndexError)):
        list(unchecked(html, wrong))


def test_a_sentence_of_unknown_make_is_found_out(tmp_path: Path) -> None:
    """Somebody adds a claim to the page and no check for it."""
    html, document = _read(cases.explained(), tmp_path)
    told = html.replace("</h1>", " No other effect explains these data as well.</h1>")
    (found,) = unchecked(told, document)
    assert "No other effect explains these data as well" in found
