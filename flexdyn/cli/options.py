"""Parts that several commands share: options, values by joint, files to write, and their names in errors."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Annotated, Any

import typer

from flexdyn.checks import check_known, number
from flexdyn.cli import completion
from flexdyn.errors import InputError
from flexdyn.io.files import check_suffix
from flexdyn.plots.picture import FILES


def flag(name: str, help: str, instead: Callable[[], None] | None = None) -> Any:
    """An option without a value; what it does instead of a command, if anything, is done before others are read."""

    def callback(wanted: bool) -> bool:
        """The flag, or the end of the program after what it does instead."""
        if wanted and instead is not None:
            instead()
            raise typer.Exit
        return wanted

    return typer.Option(name, metavar="", help=help, callback=callback, is_eager=instead is not None)


def option(metavar: str, help: str, *names: str) -> Any:
    """An option with a value; its names are by default that of the argument."""
    return typer.Option(*names, metavar=metavar, help=help)


def output_option(metavar: str, help: str) -> Any:
    """The option that says where to write."""
    return option(metavar, help, "--output", "-o")


def model_argument(metavar: str, help: str) -> Any:
    """An argument that the shell completes with the models and robots there are."""
    return typer.Argument(metavar=metavar, help=help, autocompletion=completion.models)


ModelArgument = Annotated[str, model_argument("MODEL", "A model file, or the name of a shipped model.")]
JsonOption = Annotated[bool, flag("--json", "Print JSON; infinite numbers are null.")]
MapOption = Annotated[
    Path | None, option("MAP", "A channel map (YAML): names, units and clocks of the recording.", "--map")
]


def by_joint(option: str, texts: Sequence[str], joint_names: Sequence[str]) -> dict[str, float]:
    """Values by joint from ``0.1,0.2`` (one for each joint) or ``elbow=1.57,wrist=0`` (some joints).

    Args:
        option: name of the option.
        texts: as typed; an option may be given several times.
        joint_names: of the robot.

    Raises:
        InputError: an unknown joint, too many or too few values, an entry that is no number.
    """
    entries = [entry.strip() for text in texts for entry in text.split(",")]
    if not entries:
        return {}
    named = [entry.rpartition("=") for entry in entries]
    names = [name.strip() for name, sign, _ in named if sign]
    if names and len(names) != len(entries):
        remedy = "give joint=value for each, or one value for every joint"
        raise InputError("some values name a joint, others do not", key=option, value=",".join(texts), remedy=remedy)
    if not names:
        if len(entries) != len(joint_names):
            remedy = f"the joints are {', '.join(joint_names)}; or give some as joint=value"
            problem = f"{len(joint_names)} values are needed"
            raise InputError(problem, key=option, value=",".join(texts), remedy=remedy)
        names = list(joint_names)
    values: dict[str, float] = {}
    for name, (_, _, text) in zip(names, named, strict=True):
        check_known(name, joint_names, "the robot has no such joint", key=option, value=name)
        if name in values:
            raise InputError("the joint is given twice", key=option, value=name)
        values[name] = decimal(f"{option} {name}", text)
    return values


def decimal(key: str, text: str) -> float:
    """A text as a finite number.

    Raises:
        InputError: it is none.
    """
    try:
        value = float(text)
    except ValueError:
        raise InputError("a number is needed", key=key, value=text) from None
    return number(key, value)


def span_of(option: str, text: str) -> tuple[float | None, float | None]:
    """First and last time [s] from ``START:END``; either may be left out.

    Raises:
        InputError: it is none.
    """
    first, sign, last = text.partition(":")
    if not sign or ":" in last or not (first.strip() or last.strip()):
        raise InputError(
            "a span of time is needed", key=option, value=text, remedy="give START:END in s, such as 0.5:12"
        )
    start, end = (decimal(option, end) if end.strip() else None for end in (first, last))
    if start is not None and end is not None and not start < end:
        raise InputError("the span ends before it begins", key=option, value=text, remedy="give START:END in s")
    return start, end


def output_file(option: str, path: Path | None, suffixes: Sequence[str], *, inputs: Sequence[Path | None] = ()) -> Path:
    """The file to write, checked before any work is done.

    Args:
        option: that it was given with.
        path: as given.
        suffixes: that the command can write.
        inputs: files that the command reads and must not overwrite.

    Raises:
        InputError: not given, an unknown suffix, no such folder, no right to write there, or an input.
    """
    if path is None:
        remedy = f"give a path that ends in one of {', '.join(suffixes)}"
        raise InputError("say which file to write", key=option, remedy=remedy)
    check_suffix(path, suffixes, "a file to write", key=option)
    folder = path.parent
    if not folder.is_dir():
        raise InputError("no such folder", file=path, key=option, value=str(folder), remedy="make it first")
    if path.exists() and not path.is_file():
        raise InputError("it is no regular file", file=path, key=option, remedy="give the path of a file")
    if not os.access(folder, os.W_OK):
        raise InputError("the folder cannot be written to", file=path, key=option, value=str(folder))
    for given in inputs:
        if given is not None and path.exists() and given.exists() and path.samefile(given):
            remedy = "write to another file"
            raise InputError("the command reads this file", file=path, key=option, remedy=remedy)
    return path


def picture_file(path: Path | None, inputs: Sequence[Path | None] = ()) -> Path | None:
    """The picture to write, checked as by `output_file`; None if none is asked for."""
    return None if path is None else output_file("--output", path, FILES, inputs=inputs)


def output_folder(path: Path | None, remedy: str = "") -> Path:
    """The folder of --output, checked before any work is done; it is created when there is something to write.

    Args:
        path: as given.
        remedy: what to do if it was not given.

    Raises:
        InputError: not given, a file, in a file, or it cannot be written to.
    """
    if path is None:
        raise InputError("say where to write", key="--output", remedy=remedy)
    if path.exists() and not path.is_dir():
        raise InputError("it is a file", file=path, key="--output", remedy="give a folder")
    parent = next(folder for folder in (path, *path.absolute().parents) if folder.exists())
    if not parent.is_dir():
        raise InputError("a folder cannot be made in a file", file=path, key="--output", value=str(parent))
    if not os.access(parent, os.W_OK):
        raise InputError("the folder cannot be written to", file=path, key="--output", value=str(parent))
    return path


@contextmanager
def naming(options: Mapping[str, str], *, file: Path | str, files: Mapping[str, Path | None]) -> Iterator[None]:
    """Convert errors of the Python interface to the words of the command line.

    Args:
        options: argument of the Python interface -> option.
        file: that an error without one belongs to.
        files: first word of an error's key -> file that it belongs to instead.
    """
    try:
        yield
    except InputError as error:
        if error.file:
            raise
        key = error.key or ""
        for argument, option in options.items():
            if key == argument or key.startswith(f"{argument}."):
                renamed = f"{option} {key[len(argument) + 1 :]}".strip()
                raise InputError(error.problem, **{**error.data, "key": renamed}) from None
        raise error.at(file=files.get(key.partition(".")[0].partition("[")[0]) or file) from None
