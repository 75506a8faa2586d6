"""flexdyn plot: runs and recordings as a picture."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Annotated

import typer

from flexdyn.cli.options import decimal, naming, option, output_option, picture_file
from flexdyn.cli.output import show
from flexdyn.cli.recordings import load
from flexdyn.errors import InputError
from flexdyn.plots.motions import VIEW_NAMES
from flexdyn.plots.motions import plot as draw
from flexdyn.plots.picture import FILES
from flexdyn.records import Recording

MapsOption = Annotated[
    list[Path] | None, option("MAP", "A channel map (YAML) of the first file; give it again for the second.", "--map")
]
FromOption = Annotated[str | None, option("S", "First time, in s.", "--from")]
ToOption = Annotated[str | None, option("S", "Last time, in s.", "--to")]


def plot(
    runs: Annotated[list[Path], typer.Argument(metavar="RUN...", help="Runs or recordings, the measured one first.")],
    output: Annotated[Path | None, output_option("FILE", f"The picture: {', '.join(FILES)} by its suffix.")] = None,
    views: Annotated[
        list[str] | None, option("NAME", f"One of {', '.join(VIEW_NAMES)}; may be given several times.", "--view")
    ] = None,
    joints: Annotated[
        list[str] | None, option("JOINT", "Only this one; may be given several times.", "--joint")
    ] = None,
    start: FromOption = None,
    end: ToOption = None,
    maps: MapsOption = None,
    model: Annotated[str | None, option("MODEL", "For the energy of a run whose file does not hold it (CSV).")] = None,
) -> None:
    """Draw runs and recordings: positions, deflection and torques of every joint, and the energy of runs.

    Several files share the axes; their differences from the first are drawn below. Without --output an interactive
    page opens in the browser; .html writes such a page, which works offline.
    """
    path = picture_file(output, inputs=runs)
    first, last = window(start, end)
    recordings = load_all(runs, maps)
    options = {"views": "--view", "joints": "--joint", "model": "--model", "start, end": "--from, --to"}
    with naming(options, file=", ".join(map(str, runs)), files={}):
        picture = draw(*recordings, views=views or None, joints=joints or None, start=first, end=last, model=model)
    if path is not None:
        picture.save(path)
        show(f"drawn in {path}")
    else:
        show(f"drawn in {picture.show()}, which the browser shows")
    show(*picture.notes)


def load_all(paths: Sequence[Path], maps: Sequence[Path] | None) -> list[Recording]:
    """Read recordings, each by its map if it has one.

    Args:
        paths: of the recordings.
        maps: of their channels, in the same order; there may be fewer.

    Raises:
        InputError: more maps than recordings, or a file with a fault.
    """
    maps = maps or ()
    if len(maps) > len(paths):
        remedy = "the first is of the first file, the second of the second"
        raise InputError("there are more maps than recordings", key="--map", value=str(maps[-1]), remedy=remedy)
    padded = [*maps, *[None] * (len(paths) - len(maps))]
    return [load(path, map=map) for path, map in zip(paths, padded, strict=True)]


def window(start: str | None, end: str | None) -> tuple[float | None, float | None]:
    """The options --from and --to as numbers."""
    first = None if start is None else decimal("--from", start)
    last = None if end is None else decimal("--to", end)
    if first is not None and last is not None and not first < last:
        raise InputError("the window is empty", key="--from, --to", value=f"{first:g} to {last:g} s")
    return first, last
