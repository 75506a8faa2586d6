"""flexdyn example: a model, a log with a hidden effect, and the commands to run."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from flexdyn.checks import check_known
from flexdyn.cli import completion
from flexdyn.cli.options import output_folder, output_option
from flexdyn.cli.output import show, table
from flexdyn.errors import InputError


def example(
    name: Annotated[
        str | None,
        typer.Argument(
            metavar="NAME",
            help="The example to write. Without a name, all are listed.",
            autocompletion=completion.examples,
        ),
    ] = None,
    output: Annotated[Path | None, output_option("DIR", "Folder to write to; default: NAME.")] = None,
) -> None:
    """Write an example: a model, logs of a robot with an effect that the model lacks, and commands to find it.

    The robot is simulated; its sensors are noisy. Its model lacks the effect NAME.
    """
    from flexdyn.cli.examples import EXAMPLES, commands, write_example

    if name is None:
        rows = [(known, case.words) for known, case in EXAMPLES.items()]
        show(table("Examples", ("name", "what the model lacks"), rows), "flexdyn example NAME writes one.")
        return
    check_known(name, EXAMPLES, "no such example", key="NAME", value=name)
    folder = Path(name) if output is None else output
    output_folder(folder)
    if folder.exists() and any(folder.iterdir()):
        raise InputError("the folder is not empty", file=folder, key="--output", remedy="give another with -o DIR")
    written = write_example(name, folder)
    show(f"written: {', '.join(str(path) for path in written)}", "", "Now run:", *commands(folder))
