"""flexdyn diagnose: find what a model lacks from measured motions."""

from __future__ import annotations

import json
import shlex
import sys
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer
from typer.core import TyperCommand

from flexdyn.cli import completion
from flexdyn.cli.failures import ProgramInterrupted
from flexdyn.cli.options import JsonOption, naming, output_folder, span_of
from flexdyn.cli.output import note, show, show_json
from flexdyn.cli.recordings import load_each, parts_of, trimmed
from flexdyn.cli.target import model_file
from flexdyn.errors import InputError, MissingExtra

if TYPE_CHECKING:
    from flexdyn.diagnose.report.record import Record
    from flexdyn.model.flexible_joint_model import FlexibleJointModel

CHECK, EXPLAIN = "--check", "--explain"


class DiagnoseCommand(TyperCommand):
    """The command; it reads ``--check A B`` as ``--check A --check B``."""

    def parse_args(self, ctx: Any, args: list[str]) -> list[str]:
        """Read the arguments."""
        takes = {name: 0 if getattr(entry, "is_flag", False) else 1 for entry in self.params for name in entry.opts}
        parsed: list[str] = super().parse_args(ctx, spread(args, takes))
        return parsed


def spread(args: Sequence[str], takes: Mapping[str, int]) -> list[str]:
    """The arguments with an option ``--check`` before every recording that follows ``--check``.

    Only after MODEL and FIT: before them the next word is MODEL or FIT.

    Args:
        args: as typed.
        takes: values that each option takes.
    """
    found: list[str] = []
    words, values, checking = 0, 0, False
    for place, arg in enumerate(args):
        if arg == "--":
            return [*found, *args[place:]]
        if values:
            values -= 1
        elif arg.startswith("-") and arg != "-":
            name, sign, _ = arg.partition("=")
            values = 0 if sign else takes.get(name, 0)
            checking = name == CHECK
        elif checking and words >= 2:
            found.append(CHECK)
        else:
            words += 1
        found.append(arg)
    return found


def diagnose(
    model: Annotated[
        str,
        typer.Argument(
            metavar="MODEL", help="A model file, or the name of a shipped model.", autocompletion=completion.models
        ),
    ],
    fit: Annotated[
        list[Path], typer.Argument(metavar="FIT...", help="Recordings to explain; a.csv+b.csv: side by side.")
    ],
    check: Annotated[
        list[Path] | None,
        typer.Option(
            CHECK,
            metavar="CHECK...",
            help="Test data, which no decision reads. Default: the last fifth of what moves in every recording of FIT.",
        ),
    ] = None,
    maps: Annotated[
        list[Path] | None,
        typer.Option(
            "--map",
            metavar="MAP",
            help="A channel map (YAML) of every recording; or one for each, in their order, FIT before CHECK.",
        ),
    ] = None,
    trim: Annotated[
        list[str] | None,
        typer.Option(
            "--trim",
            metavar="START:END",
            help="Use this span of every recording, in s; or one for each, in their order.",
        ),
    ] = None,
    hold_out: Annotated[
        list[str] | None,
        typer.Option(
            "--hold-out",
            metavar="START:END",
            help="A block of the recordings of FIT that is kept apart as test data, in s. May be given again.",
        ),
    ] = None,
    expect: Annotated[
        list[str] | None,
        typer.Option(
            "--expect",
            metavar="EFFECT",
            help="An effect that the drive is likely to have, by its data sheet.",
        ),
    ] = None,
    explain: Annotated[
        list[str] | None,
        typer.Option(
            EXPLAIN,
            metavar="EFFECT@JOINT",
            help="Say why an effect was named or was not: coulomb_friction@elbow, channel_lag@q.elbow, payload.",
        ),
    ] = None,
    output: Annotated[
        Path | None,
        typer.Option("--output", "-o", metavar="DIR", help="Folder for report.html, report.json and model.yaml."),
    ] = None,
    as_json: JsonOption = False,
) -> None:
    """Find where model and measurement disagree, and name what is missing in the model.

    It writes a report, for people and for programs, and the corrected model. Ctrl-C writes what is known by then.
    """
    from flexdyn.diagnose.report.result import Interrupted as Partial

    checks, targets = check or [], explain or []
    folder = _folder(output, [Path(model), *fit, *checks])
    _check_twice(fit, checks)
    _check_pictures()
    arm = model_file(model)
    _check_targets(arm, targets)
    blocks = [_block(text) for text in hold_out or ()]
    loaded = trimmed(load_each([*fit, *checks], maps or ()), trim or ())
    recordings = [loaded[: len(fit)], loaded[len(fit) :]]
    from flexdyn.diagnose import diagnose as run

    done = _record(model, fit, checks, maps or ())
    try:
        options = {"fit": "FIT", "check": CHECK, "expect": "--expect", "hold_out": "--hold-out"}
        with naming(options, file=_named(fit), files={}):
            diagnosis = run(arm, *recordings, hold_out=blocks, expect=expect or ())
    except Partial as stop:
        if stop.diagnosis is not None:
            replace(stop.diagnosis, verdict="interrupted", record=done()).save(folder)
            note(f"what was known by then is in {folder / 'report.html'}")
        raise ProgramInterrupted from None
    diagnosis = replace(diagnosis, record=done())
    diagnosis.save(folder)
    told = {target: diagnosis.explain(target) for target in targets}
    if as_json:
        document = json.loads((folder / "report.json").read_text(encoding="utf-8"))
        show_json(document | ({"explanations": told} if told else {}))
    else:
        from flexdyn.cli.diagnosis_text import diagnosis_text

        show(*diagnosis_text(diagnosis, folder), *told.values())


def _block(text: str) -> tuple[float, float]:
    """A block that is kept apart: both ends are needed."""
    first, last = span_of("--hold-out", text)
    if first is None or last is None:
        raise InputError("a block has a first and a last time", key="--hold-out", value=text, remedy="give both, in s")
    return first, last


def _record(model: str, fit: Sequence[Path], check: Sequence[Path], maps: Sequence[Path]) -> Callable[[], Record]:
    """What is told of the command and its files once it is done; files as they are now, before anything is read."""
    from flexdyn.diagnose.report.record import File, record

    uses = [(Path(model), "model"), *((path, "fit") for path in fit), *((path, "test") for path in check)]
    uses += [(each, "channel map") for each in maps]
    files = [File.of(part, use) for path, use in uses for part in parts_of(path)]
    return lambda: record(shlex.join(["flexdyn", *sys.argv[1:]]), files)


def _check_targets(model: FlexibleJointModel, targets: Sequence[str]) -> None:
    """What is to be explained exists: better said now than after the work."""
    from flexdyn.diagnose.report.targets import check_target

    with naming({"explain": EXPLAIN}, file="", files={}):
        for target in targets:
            check_target(model, target)


def _folder(path: Path | None, inputs: Sequence[Path]) -> Path:
    """The folder to write to, found fit before any work is done."""
    if path is None:
        raise InputError("say where to write", key="--output", remedy="give a folder for the report")
    output_folder(path)
    for name in ("model.yaml", "report.json", "report.html"):
        for given in inputs:
            if (path / name).exists() and given.exists() and given.samefile(path / name):
                remedy = "write to another folder"
                raise InputError("the command reads this file", file=given, key="--output", remedy=remedy)
    return path


def _check_twice(fit: Sequence[Path], check: Sequence[Path]) -> None:
    """Data that check an answer may not have given it."""
    for path in check:
        if any(path.exists() and other.exists() and path.samefile(other) for other in fit):
            remedy = "give another recording, or none: then the last fifth of every one is kept for the test"
            raise InputError("it is one of FIT too", file=path, key=CHECK, remedy=remedy)


def _check_pictures() -> None:
    """What the report is drawn with is there: better said now than after minutes of work."""
    from importlib.util import find_spec

    for library in ("matplotlib", "plotly"):
        if find_spec(library) is None:
            raise MissingExtra(library, "plot")


def _named(paths: Sequence[Path]) -> str:
    return ", ".join(map(str, paths[:3])) + (f" and {len(paths) - 3} more" if len(paths) > 3 else "")
