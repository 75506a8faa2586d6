"""flexdyn paper: the paper's study, run again."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Annotated, Any

import typer

from flexdyn.cli.options import JsonOption, output_folder, output_option
from flexdyn.cli.output import cell, progress, show, show_json, table

DIAGNOSES = "Also hide the friction from the model, and let the diagnosis find it. Takes a minute."


def paper(
    output: Annotated[
        Path, output_option("DIR", "Folder for figures, tables and runs; made if it is not there.")
    ] = Path("flexdyn_paper"),
    diagnose: Annotated[bool, typer.Option("--diagnose", help=DIAGNOSES)] = False,
    as_json: JsonOption = False,
) -> None:
    """Run the paper's study on elastic joints and friction.

    It writes figures, tables and runs. Every check compares a number with its bound; exit code 1 if one fails.
    """
    output_folder(output)
    from flexdyn.paper import run_paper_study

    with progress("the paper's study") as report:
        study = run_paper_study(output, diagnose=diagnose, progress=report)
    if as_json:
        show_json(study.summary)
    else:
        rows = [
            (check.name, cell(float(check.value)), cell(float(check.bound)), "passed" if check.passed else "FAILED")
            for check in study.checks
        ]
        if diagnose:
            show(*_found(study.summary, output))
        columns = ("check", "value", "bound", "result")
        show(table("Checks", columns, rows, right=("value", "bound")), f"Figures, tables and runs are in {output}")
    if not study.passed:
        raise typer.Exit(1)


def _found(summary: Mapping[str, Any], output: Path) -> Iterator[Any]:
    """The hidden effects and the findings, the gap after each step, and the path of the report."""
    from flexdyn.diagnose import Number
    from flexdyn.diagnose.report.digits import estimate_text, times
    from flexdyn.diagnose.report.words import effect_name, place_phrase
    from flexdyn.paper.hidden_friction import CHAPTER_TITLE, FOLDER

    told = summary["numbers"][CHAPTER_TITLE]
    rows = []
    for each in told["hidden"]:
        estimate = None if each["found"] is None else Number(each["found"], each["std"], each["unit"])
        found = "not found" if estimate is None else estimate_text(estimate)
        name = f"{effect_name(each['effect'])} {place_phrase(each['joint'], each['side'])}"
        rows.append((name, each["parameter"], cell(each["true"]), found))
    columns = ("hidden", "number", "true", "found")
    yield table(CHAPTER_TITLE, columns, rows, right=columns[2:])
    steps = [(each["name"], times(each["gap"])) for each in told["gap"]]
    yield table("Gap on data not used in the fit", ("model", "in units of noise"), steps, right=("in units of noise",))
    yield f"The diagnosis is in {output / FOLDER / 'report.html'}"
