"""Results of two commits: what differs is found, what belongs to the machine is left out."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any


def _written(folder: Path, **files: Any) -> Path:
    folder.mkdir()
    for name, content in files.items():
        (folder / f"{name}.json").write_text(json.dumps(content), encoding="utf-8")
    return folder


def test_differences_are_found_and_times_are_not(tmp_path: Path) -> None:
    """A last digit, a word, a value that is missing, a file that is missing; no seconds, dates or versions."""
    from same_results import compared, same_results_table

    one = {"date": "Monday", "rows": [{"error": 0.1, "seconds": 1.0}, {"error": 0.2, "verdict": "explained"}]}
    other = {
        "date": "Friday",
        "rows": [{"error": 0.1, "seconds": 2.0}, {"error": 0.2 + 1e-16 * 2, "verdict": "untested"}],
    }
    before = _written(tmp_path / "before", same=one, changed=one, gone=[1, 2])
    after = _written(tmp_path / "after", same={**one, "date": "Friday"}, changed={**other, "more": 1})
    found = compared(before, after)
    assert {name: row["values"] for name, row in found.items()} == {"changed": 4, "gone": 2, "same": 3}
    assert found["same"]["different"] == []
    assert found["changed"]["different"] == [
        "changed.json/more",
        "changed.json/rows/1/error",
        "changed.json/rows/1/verdict",
    ]
    assert len(found["gone"]["different"]) == 2
    assert "| `changed` | 4 | 3 |" in same_results_table({"commits": ["a", "b"], "benchmarks": found})
