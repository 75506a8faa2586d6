"""flexdyn compare-models: numbers and effects over several models of one arm."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import typer

from flexdyn.cli.options import JsonOption
from flexdyn.cli.output import answer, table
from flexdyn.diagnose.compared.models import ModelsCompared
from flexdyn.diagnose.compared.models import compare_models as compare

LEGEND = {
    "+-": "standard error; of a model that no diagnosis wrote, its tolerance",
    "by chance": "probability that equal numbers with these errors differ so much",
    "moved": "by more than chance and these uncertainties make (three standard deviations)",
    "stayed": "it did not, and a change by a quarter would have been seen",
    "not told": "too uncertain to say",
}


def compare_models(
    models: Annotated[
        list[Path],
        typer.Argument(metavar="MODEL...", help="Two or more: model files, or folders that a diagnosis wrote."),
    ],
    as_json: JsonOption = False,
) -> None:
    """Compare models of one arm: which numbers moved, which stayed, which effects appeared or vanished.

    Values are compared by their standard deviations, which a diagnosis keeps in the report.json beside its model.yaml.
    """
    answer(compare(models), report, as_json)


def report(found: ModelsCompared) -> list[Any]:
    """What is printed."""
    numbers, effects = found.heads
    right = (*found.labels, "by chance")
    parts: list[Any] = [table("Numbers", numbers, found.number_rows(), right=right, legend=LEGEND)]
    if found.effects:
        parts.append(table("Effects", effects, found.effect_rows()))
    return parts
