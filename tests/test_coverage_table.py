"""The table of coverage: shares by package, and modules that no test touches."""

from __future__ import annotations

import importlib.util
from pathlib import Path
from typing import Any

SCRIPT = Path(__file__).parents[1] / "scripts" / "coverage_table.py"


def _found(statements: int, ran: int, *functions: int) -> dict[str, Any]:
    """Of one module, as coverage reports it: statements that ran, and of those the ones of each function."""
    named = {f"f{k}": {"summary": {"covered_lines": count}} for k, count in enumerate(functions)}
    summary = {"num_statements": statements, "covered_lines": ran}
    return {"summary": summary, "functions": {"": {"summary": {"covered_lines": ran - sum(functions)}}, **named}}


def test_shares_by_package_and_what_is_untouched() -> None:
    """Statements are added up; a module whose head alone ran is untouched, one without statements is not."""
    spec = importlib.util.spec_from_file_location("coverage_table", SCRIPT)
    assert spec is not None
    assert spec.loader is not None
    script = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(script)
    files = {
        "flexdyn/errors.py": _found(10, 9, 4),
        "flexdyn/records/a.py": _found(20, 20, 15),
        "flexdyn/records/csv/b.py": _found(20, 10, 0, 0),
        "flexdyn/records/csv/__init__.py": _found(0, 0),
    }
    assert script.table(files).splitlines() == [
        "| package | statements | run |",
        "| --- | ---: | ---: |",
        "| all | 50 | 78.0% |",
        "| its root | 10 | 90.0% |",
        "| records | 40 | 75.0% |",
        "",
        "Modules of which no function ran: flexdyn/records/csv/b.py.",
    ]
