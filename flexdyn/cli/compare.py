"""flexdyn compare: the errors between two runs or recordings."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import typer

from flexdyn.cli.options import JsonOption, naming, output_option, picture_file
from flexdyn.cli.output import answer, number, show, table
from flexdyn.cli.plot import FromOption, MapsOption, ToOption, load_all, window
from flexdyn.comparison.compare import Comparison
from flexdyn.comparison.compare import compare as compare_two
from flexdyn.plots.picture import FILES

COLUMNS = ("channel", "unit", "RMS", "largest", "at [s]", "bias", "RMS / spread")
LEGEND = {
    "RMS": "root mean square of the error",
    "largest": "largest error, and when it was",
    "bias": "mean error",
    "spread": "standard deviation of the first one's channel",
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
    answer(found, report, as_json)
    if path is not None and not as_json:
        show(f"drawn in {path}")


def report(found: Comparison) -> list[Any]:
    """The text for a comparison."""
    head = (
        f"{found.second} - {found.first}, {found.samples} samples of {found.first} "
        f"from {number(found.start, 6)} to {number(found.end, 6)} s"
    )
    rows = [
        (row.channel, row.unit or "-", *map(number, (row.rms, row.largest, row.at, row.bias, row.relative)))
        for row in found.rows
    ]
    parts: list[Any] = [head, table("Errors", COLUMNS, rows, right=COLUMNS[2:], legend=LEGEND)]
    for name, only in ((found.first, found.only_first), (found.second, found.only_second)):
        if only:
            parts.append(f"only in {name}: {', '.join(only)}")
    return parts
