"""The tables of the wheels: their sizes, and what became of them where nothing was installed."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from result_tables import markdown_table


def wheels_table(results: Mapping[str, Any]) -> str:
    """Sizes of the files of a release; then a row for each trial, and for what was not tried."""
    files = [[f"`{name}`", f"{size:.2f}"] for name, size in results["files"].items()]
    head = ["Python", "installed by", "libraries", "pin, NumPy, SciPy", "test"]
    head += ["environment, MB", "from nothing to `flexdyn paper` done, s", "of it computing, s"]
    rows = []
    for row in results["trials"]:
        versions = ", ".join(row["libraries"][name] for name in ("pin", "numpy", "scipy"))
        which = "oldest of these three" if row["oldest"] else "newest"
        said = ["works" if row["problem"] is None else row["problem"]]
        numbers = [f"{row[key]:,.0f}" if key in row else "-" for key in ("megabytes", "seconds", "computing")]
        rows.append([row["python"], row["by"], which, versions, *said, *numbers])
    rows += [[name, "-", "-", "-", "not tried", "-", "-", "-"] for name in results["not_tried"]]
    return markdown_table(["file", "size, MB"], files) + "\n\n" + markdown_table(head, rows, text=5)
