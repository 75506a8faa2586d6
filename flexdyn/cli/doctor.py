"""flexdyn doctor: what is installed, what is not, and whether it works."""

from __future__ import annotations

from typing import Any

from flexdyn.cli.options import JsonOption
from flexdyn.cli.output import show, show_json, table

FAULT = 1
"""Exit code where the self-test fails."""


def doctor(as_json: JsonOption = False) -> int:
    """Show which versions and extras are installed, and test in a second that they work.

    Paste the output into a bug report. Exit code 1 if a test fails.
    """
    from flexdyn.cli.health import EXTRAS, compiler, extras, self_test, versions

    document: dict[str, Any] = {
        "versions": versions(),
        "extras": extras(),
        "compiler": compiler(),
        "tests": self_test(),
    }
    failed = [test["name"] for test in document["tests"] if not test["passed"]]
    if as_json:
        show_json(document)
        return FAULT if failed else 0
    lacking = [extra["name"] for extra in document["extras"] if not extra["works"]]
    found = [(extra["name"], extra["state"], EXTRAS[extra["name"]][0]) for extra in document["extras"]]
    tested = [(test["name"], "yes" if test["passed"] else "NO", test["measured"]) for test in document["tests"]]
    show(
        table("Versions", ("what", "version"), document["versions"].items()),
        table("Extras", ("extra", "state", "for"), found),
        f"C++ compiler: {document['compiler'] or 'none found'} (needed only to build flexdyn from source)",
        table("Self-test", ("test", "passed", "measured"), tested),
    )
    if lacking:
        show(f"To add what is missing: pip install 'flexdyn[{','.join(lacking)}]'")
    show(f"Failed: {', '.join(failed)}" if failed else "Everything that was tested works.")
    return FAULT if failed else 0
