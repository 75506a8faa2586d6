"""Write a study's page: its template, filled with what the study found."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
from measure import Bound
from result_tables import markdown_table
from told import calibration_table, findings_text, gap_text

from flexdyn.io.html import engine


def fill_page(script: str, made: Any, held: Sequence[Bound], folder: Path, **filled: Any) -> None:
    """Write page.md into a folder.

    Args:
        script: path of the file that draws the page; the template stands beside it, as ``.md``.
        made: the study.
        held: bounds that must hold.
        folder: to write into.
        filled: what else the template names.
    """
    template = engine().overlay(autoescape=False).from_string(Path(script).with_suffix(".md").read_text("utf-8"))
    checks = "\n".join(f"- {each}" for each in held)
    said = {"findings_text": findings_text, "gap_text": gap_text, "calibration_table": calibration_table}
    text = template.render(made=made, checks=checks, markdown_table=markdown_table, **said, **filled)
    (folder / "page.md").write_text(text.rstrip("\n") + "\n", encoding="utf-8")
