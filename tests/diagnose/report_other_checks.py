"""What report.json must hold for a claim of report.html about numbers, pictures, next measurements and the record."""

from __future__ import annotations

import math
from typing import Any

from tests.diagnose.report_told import Document, agrees


def noise_leaves(document: Document, share: str) -> None:
    """What noise leaves; the shares beside it add up."""
    assert agrees(share, document["shares"]["noise"], 100.0)
    given = document["shares"]
    assert math.isclose(given["calibration"] + sum(given["findings"]) + given["left"], 1.0, abs_tol=1e-9)


def dashed(document: Document, floor: str) -> None:
    """The floor of one of the gaps."""
    floors = [entry["floor"] for entry in document["gap"].values() if entry is not None]
    assert any(agrees(floor, value) for value in floors)


def _drift(entry: dict[str, Any]) -> float:
    return abs(float(entry["factor"]) - 1.0) / (float(entry["tolerance"]) or 1.0)


def within_tolerance(document: Document, limit: str) -> None:
    """No number moved farther."""
    assert all(_drift(each) <= float(limit) for each in document["calibration"])


def beyond_tolerance(document: Document, count: str, limit: str) -> None:
    """So many numbers moved farther."""
    assert sum(_drift(each) > float(limit) for each in document["calibration"]) == int(count)


def nothing_to_note(document: Document) -> None:
    """No notes but those of the head."""
    assert [note for note in document["notes"] if "model.yaml" not in note] == []


def nothing_to_measure(document: Document) -> None:
    """No finding has an experiment."""
    assert not [each for each in document["findings"] if each["experiment"]]


def more_motion(document: Document, joint: str, regime: str | None) -> None:
    """A joint at which something is left."""
    assert document["verdict"] in ("unexplained", "partly_explained")
    assert joint in {each["joint"] for each in (*document["where"], *document["left"])}
    assert regime is None or any(each["regime"] == regime for each in document["where"])


def once_more(document: Document) -> None:
    """Something is left."""
    assert document["verdict"] in ("unexplained", "partly_explained")


def second_recording(document: Document) -> None:
    """There were no test data."""
    assert document["gap"]["test"] is None


def to_its_end(document: Document) -> None:
    """It was interrupted."""
    assert document["verdict"] == "interrupted"


def took(document: Document, seconds: str) -> None:
    """To the second."""
    assert abs(document["seconds"] - float(seconds)) <= 0.51


def done(document: Document, version: str, command: str) -> None:
    """Version and command."""
    record = document["record"]
    assert version == record["version"]
    assert command == (record["command"] or "called from Python")


def planned(document: Document, times: str) -> None:
    """The experiment that is proposed says the same."""
    assert any(f"{times} times the noise" in each["experiment"] for each in document["findings"])
