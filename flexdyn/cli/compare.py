"""flexdyn compare: the errors between two runs or recordings; flexdyn compare-models: several models of one arm."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import typer

from flexdyn.cli.options import JsonOption, naming, output_option, picture_file
from flexdyn.cli.output import answer, cell, table
from flexdyn.cli.plot import FromOption, MapsOption, ToOption, load_all, window
from flexdyn.comparison.compare import Comparison
from flexdyn.comparison.compare import compare as compare_two
from flexdyn.diagnose.compared.models import compare_models as compare_arms
from flexdyn.diagnose.compared.over_models import ModelsCompared
from flexdyn.plots.picture import FILES

COLUMNS = ("channel", "unit", "RMS", "largest", "at [s]", "bias", "RMS / spread")
ERRORS_LEGEND = {
    "RMS": "root mean square of the error",
    "largest": "largest error, and when it was",
    "bias": "mean error",
    "spread": "standard deviation of the first one's channel",
}
MODELS_LEGEND = {
    "+-": "standard error; of a model that no diagnosis wrote, its tolerance",
    "by chance": "probability that equal numbers with these errors differ so much",
    "moved": "by more than chance and these uncertainties make (three standard deviations)",
    "stayed": "it did not, and a change by a quarter would have been seen",
    "not told": "too uncertain to say",
}


def compare(
    first: Annotated[Path, typer.Argument(metavar="FIRST", help="A run or recording: the reference.")],
    second: Annotated[Path, typer.Argument(metavar="SECOND", help="The run or recording to compare with FIRST.")],
    output: Annotated[Path | None, output_option("FILE", f"A picture: {', '.join(FILES)} by its suffix.")] = None,
    start: FromOption = None,
    end: ToOption = None,
    maps: MapsOption = None,
    as_json: JsonOption = False,
) -> None:
    """Compare two runs or recordings: the errors of every channel that both have, second - first.

    Errors are computed at the times of FIRST that both cover. SECOND is interpolated linearly; tau and tau_applied
    are held from sample to sample. Spread is the standard deviation of FIRST. Large errors do not change the exit code.
    """
    path = picture_file(output, inputs=(first, second))
    low, high = window(start, end)
    one, two = load_all([first, second], maps)
    with naming({}, file=f"{first}, {second}", files={}):
        found = compare_two(one, two, start=low, end=high)
        if path is not None:
            found.plot(path)
    answer(found, comparison_text, as_json, path)


def comparison_text(found: Comparison) -> list[Any]:
    """The text for a comparison."""
    head = (
        f"{found.second} - {found.first}, {found.samples} samples of {found.first} "
        f"from {cell(found.start, 6)} to {cell(found.end, 6)} s"
    )
    rows = [
        (row.channel, row.unit or "-", *map(cell, (row.rms, row.largest, row.at, row.bias, row.relative)))
        for row in found.rows
    ]
    parts: list[Any] = [head, table("Errors", COLUMNS, rows, right=COLUMNS[2:], legend=ERRORS_LEGEND)]
    for name, only in ((found.first, found.only_first), (found.second, found.only_second)):
        if only:
            parts.append(f"only in {name}: {', '.join(only)}")
    return parts


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
    answer(compare_arms(models), models_report, as_json)


def models_report(found: ModelsCompared) -> list[Any]:
    """What is printed."""
    numbers, effects = found.heads
    right = (*found.labels, "by chance")
    parts: list[Any] = [table("Numbers", numbers, found.number_rows(), right=right, legend=MODELS_LEGEND)]
    if found.effects:
        parts.append(table("Effects", effects, found.effect_rows()))
    return parts
