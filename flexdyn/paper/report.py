"""The study's summary: Markdown for people, plain data for programs."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

from flexdyn.paper.chapter import Chapter, Check
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
        "checks": [_plain(asdict(check)) for check in checks],
        "numbers": {chapter.title: _plain(chapter.numbers) for chapter in chapters if chapter.numbers},
        "readings": [asdict(reading) for reading in readings],
        "figures": {figure.name: figure.caption for chapter in chapters for figure in chapter.figures},
        "runs": {name: _run_data(run) for chapter in chapters for name, run in chapter.runs.items()},
    }


def summary_text(chapters: Sequence[Chapter], readings: Sequence[Reading], version: str) -> str:
    """The same to read, figures embedded."""
    checks = [check for chapter in chapters for check in chapter.checks]
    passed = sum(check.passed for check in checks)
    parts = [
        "# The paper's study, reproduced",
        f"*{TITLE}*, Amirkabir 8/30, with flexdyn {version}: the two-link SCARA of Table I (`scara_two_link`). The "
        "copy of the paper at hand is a scan turned into text: its figures are missing, and some misprints listed here "
        "may be the scan's. Numbers that the paper leaves out are chosen and named.",
        f"**{passed} of {len(checks)} checks hold.**",
        _check_table(checks),
    ]
    for chapter in chapters:
        parts += [f"## {chapter.title}", chapter.text]
        for figure in chapter.figures:
            caption = _escaped(figure.caption)
            parts.append(f"![{caption}]({figure.name}.png)\n\n*{caption}* ([PDF]({figure.name}.pdf))")
    parts += ["## Ambiguities and misprints, and the reading chosen", _reading_table(readings)]
    parts += ["## Runs for playback", *_run_list(chapters)]
    return "\n\n".join(parts) + "\n"


def _check_table(checks: Sequence[Check]) -> str:
    rows = [
        f"| {_escaped(check.name)} | {check.value:.3g} | {check.bound:g} | {'yes' if check.passed else '**NO**'} | "
        f"{_escaped(check.note)} |"
        for check in checks
    ]
    return "\n".join(["| check | value | at most | holds | unit, how measured |", "|---|---|---|---|---|", *rows])


def _reading_table(readings: Sequence[Reading]) -> str:
    rows = ["| " + " | ".join(_escaped(text) for text in asdict(each).values()) + " |" for each in readings]
    return "\n".join(["| where | printed | read as | why |", "|---|---|---|---|", *rows])


def _run_list(chapters: Sequence[Chapter]) -> list[str]:
    lines, notes = [], dict[str, None]()
    for chapter in chapters:
        for name, run in chapter.runs.items():
            lines.append(f"- `{Path('runs') / name}.npz`: {_run_line(run)}")
            notes |= dict.fromkeys(run.notes)
    said = [f"Noted by these runs: {'; '.join(notes)}."] if notes else []
    return ["\n".join(lines), *said]


def _run_line(run: Run) -> str:
    return f"{run.t[-1]:g} s at {(len(run.t) - 1) / run.t[-1]:g} Hz, {type(run.solver).__name__}"


def _run_data(run: Run) -> dict[str, Any]:
    return {
        "duration_s": float(run.t[-1]),
        "samples": len(run.t),
        "solver": run.solver.to_dict(),
        "notes": [*run.notes],
    }


def _plain(value: Any) -> Any:
    """Nested data in a form for JSON: mappings as dicts, numbers that are not finite as null."""
    if isinstance(value, Mapping):
        return {str(key): _plain(each) for key, each in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(each) for each in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value


def _escaped(text: str) -> str:
    """Text for a cell: a bar would end it, stars and underscores would set it in italics, < would open a tag."""
    for mark in ("|", "*", "_", "<"):
        text = text.replace(mark, "\\" + mark)
    return text
