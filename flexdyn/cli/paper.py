"""flexdyn paper: the paper's study, run again."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Annotated

import typer

from flexdyn.cli.options import JsonOption, output_folder
from flexdyn.cli.output import console, number, show, show_json, table


def paper(
    output: Annotated[
        Path,
        typer.Option(
            "--output", "-o", metavar="DIR", help="Folder for figures, tables and runs; made if it is not there."
        ),
    ] = Path("flexdyn_paper"),
    as_json: JsonOption = False,
) -> None:
    """Run the paper's study on elastic joints and friction.

    It writes figures, tables and runs. Every check compares a number with its bound; exit code 1 if one fails.
    """
    output_folder(output)
    from flexdyn.paper import run_study

    with _progress() as progress:
        study = run_study(output, progress=progress)
    passed = all(check.passed for check in study.checks)
    if as_json:
        show_json(study.summary)
    else:
        rows = [
            (check.name, number(float(check.value)), number(float(check.bound)), "passed" if check.passed else "FAILED")
            for check in study.checks
        ]
        columns = ("check", "value", "bound", "result")
        show(table("Checks", columns, rows, right=("value", "bound")), f"Figures, tables and runs are in {output}")
    if not passed:
        raise typer.Exit(1)


@contextmanager
def _progress() -> Iterator[Callable[[str], None] | None]:
    """The part of the study in work, on stderr where that is a terminal."""
    err = console(stderr=True)
    if not err.is_terminal:
        yield None
        return
    with err.status("the paper's study") as status:
        yield status.update
