"""The study's summary: Markdown for people, plain data for programs."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict
from typing import Any

from flexdyn.io.json_text import jsonable
from flexdyn.paper.chapter import Chapter, prose
from flexdyn.paper.readings import Reading
from flexdyn.simulation.run import Run

TITLE = "The Effect of Friction on the Formulation and Numerical Solution of Elastic Joint Manipulators"


def summary_data(chapters: Sequence[Chapter], readings: Sequence[Reading], version: str) -> dict[str, Any]:
    """Everything measured, as it goes to summary.json."""
    checks = [check for chapter in chapters for check in chapter.checks]
    return {
        "schema": "flexdyn.paper/1",
        "flexdyn": version,
        "paper": TITLE,
        "passed": all(check.passed for check in checks),
        "checks": [jsonable(asdict(check)) for check in checks],
        "numbers": {chapter.title: jsonable(chapter.numbers) for chapter in chapters if chapter.numbers},
        "readings": [asdict(reading) for reading in readings],
        "figures": {figure.name: figure.caption for chapter in chapters for figure in chapter.figures},
        "runs": {name: _run_data(run) for chapter in chapters for name, run in chapter.runs.items()},
    }


def summary_text(chapters: Sequence[Chapter], readings: Sequence[Reading], version: str) -> str:
    """The same to read, figures embedded."""
    runs = {name: run for chapter in chapters for name, run in chapter.runs.items()}
    text = prose(
        "summary.md",
        paper=TITLE,
        version=version,
        checks=[check for chapter in chapters for check in chapter.checks],
        chapters=chapters,
        readings=readings,
        runs=runs,
        notes=list(dict.fromkeys(note for run in runs.values() for note in run.notes)),
        solver=lambda run: type(run.solver).__name__,
        cell=_escaped,
    )
    return text.rstrip("\n") + "\n"


def _run_data(run: Run) -> dict[str, Any]:
    return {
        "duration_s": float(run.t[-1]),
        "samples": len(run.t),
        "solver": run.solver.to_dict(),
        "notes": [*run.notes],
    }


def _escaped(text: str) -> str:
    """Text for a cell: a bar would end it, stars and underscores would set it in italics, < would open a tag."""
    for mark in ("|", "*", "_", "<"):
        text = text.replace(mark, "\\" + mark)
    return text
