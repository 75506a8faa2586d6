"""flexdyn play: a run in the browser, or in one HTML file."""

from __future__ import annotations

import contextlib
from pathlib import Path
from typing import Annotated

import typer

from flexdyn.cli.options import MapOption, decimal, flag, naming, option, output_file
from flexdyn.cli.output import note, show
from flexdyn.cli.recordings import load
from flexdyn.cli.target import find
from flexdyn.errors import InputError
from flexdyn.model.flexible_joint_model import FlexibleJointModel
from flexdyn.records import Recording
from flexdyn.records.files import is_recording

OPTION_OF_KEY = {"magnify": "--magnify", "command": "--command"}


def play(
    run: Annotated[
        str, typer.Argument(metavar="RUN|MODEL", help="A recording; or a model or robot, shown in its first position.")
    ],
    other: Annotated[
        Path | None,
        typer.Argument(metavar="OTHER", help="A recording of the same arm, shown as a translucent second one."),
    ] = None,
    model: Annotated[
        str | None, option("MODEL", "The model of the arm, for a recording that does not hold it (CSV).")
    ] = None,
    map: MapOption = None,
    rigid: Annotated[
        bool,
        flag("--rigid", "In place of OTHER: the same arm without elasticity, replaying the tau of RUN in open loop."),
    ] = False,
    command: Annotated[
        Path | None, option("FILE", "With --rigid: the command of that arm (YAML), for example the controller of RUN.")
    ] = None,
    html: Annotated[Path | None, option("FILE", "Write one HTML file that plays offline, and serve nothing.")] = None,
    magnify: Annotated[
        str | None, option("F", "Factor of theta - q on the dials. Default: one that makes the deflection easy to see.")
    ] = None,
    no_open: Annotated[bool, flag("--no-open", "Do not open the browser.")] = False,
) -> None:
    """Play a run in the browser.

    The page is served on 127.0.0.1 until Ctrl-C. It shows the arm, at each elastic joint a dial with the deflection
    magnified, and the path of the tip. --map belongs to OTHER, or to RUN if there is no OTHER.
    """
    from flexdyn.viewer.playback import play as watch
    from flexdyn.viewer.rigid import RIGID

    if html is not None:
        output_file("--html", html, (".html", ".htm"), inputs=(Path(run), other))
    if rigid and other is not None:
        problem = "there is one translucent arm: OTHER or the rigid one"
        raise InputError(problem, key="--rigid", value=str(other), remedy="leave one of them out")
    if command is not None and not rigid:
        raise InputError("a command is for the rigid arm alone", key="--command", remedy="give --rigid too")
    factor = None if magnify is None else decimal("--magnify", magnify)
    arm = None if model is None else find(model).model
    with naming(
        OPTION_OF_KEY | ({"compare": "--rigid"} if rigid else {}), file=run, files={"compare": other, "pd": command}
    ):
        playback = watch(
            _source(run, map if other is None else None),
            RIGID if rigid else None if other is None else load(other, map=map),
            model=arm,
            command=command,
            html=html,
            magnify=factor,
            open_browser=not no_open,
            block=False,
        )
    if html is not None:
        show(f"{html}: {html.stat().st_size / 1e6:.1f} MB, opens in any browser, offline too")
        return
    with contextlib.suppress(KeyboardInterrupt), playback:  # Ctrl-C may come as soon as the address is read
        show(f"{run} at {playback.url} (Ctrl-C ends)")
        playback.wait()
    note("stopped")


def _source(run: str, map: Path | None) -> Recording | FlexibleJointModel:
    """A recording, else the model or robot of that name."""
    path = Path(run)
    return load(path, map=map) if is_recording(path) else find(run).model
