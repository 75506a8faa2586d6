"""flexdyn diagnose: find what a model lacks from measured motions."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Annotated, Any

import typer
from typer.core import TyperCommand

from flexdyn.cli import diagnose_inputs
from flexdyn.cli.failures import ProgramInterrupted
from flexdyn.cli.options import JsonOption, ModelArgument, naming, option, output_option
from flexdyn.cli.output import note, show, show_json
from flexdyn.cli.recordings import load_each, trimmed_recordings
from flexdyn.cli.target import model_file
from flexdyn.errors import check_installed
from flexdyn.model.model_file import TOP_KEYS

FitArgument = Annotated[
    list[Path], typer.Argument(metavar="FIT...", help="Recordings to explain; a.csv+b.csv: side by side.")
]
CHECK_OPTION = option(
    "CHECK...",
    "Test data, which no decision reads. Default: the last fifth of the motion in every recording of FIT.",
    diagnose_inputs.CHECK,
)
MAPS_OPTION = option(
    "MAP", "A channel map (YAML) of every recording; or one for each, in their order, FIT before CHECK.", "--map"
)
TRIM_OPTION = option("START:END", "Use this span of every recording, in s; or one for each, in their order.", "--trim")
HOLD_OUT_OPTION = option(
    "START:END",
    "From START to END, in s, the recordings of FIT are kept as test data. May be given several times.",
    "--hold-out",
)
EXPECT_OPTION = option("EFFECT", "An effect that the drive is likely to have, by its data sheet.", "--expect")
EXPLAIN_OPTION = option(
    "EFFECT@JOINT",
    "Say why an effect was named or was not: coulomb_friction@elbow, channel_lag@q.elbow, payload.",
    diagnose_inputs.EXPLAIN,
)
OUTPUT_OPTION = output_option("DIR", "Folder for report.html, report.json and model.yaml.")


class DiagnoseCommand(TyperCommand):
    """The command; it reads ``--check A B`` as ``--check A --check B``."""

    def parse_args(self, ctx: Any, args: list[str]) -> list[str]:
        """Read the arguments."""
        takes = {name: 0 if getattr(entry, "is_flag", False) else 1 for entry in self.params for name in entry.opts}
        return list(super().parse_args(ctx, repeated_option(args, takes)))


def repeated_option(args: Sequence[str], takes: Mapping[str, int]) -> list[str]:
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
            checking = name == diagnose_inputs.CHECK
        elif checking and words >= 2:
            found.append(diagnose_inputs.CHECK)
        else:
            words += 1
        found.append(arg)
    return found


def diagnose(
    model: ModelArgument,
    fit: FitArgument,
    check: Annotated[list[Path] | None, CHECK_OPTION] = None,
    maps: Annotated[list[Path] | None, MAPS_OPTION] = None,
    trim: Annotated[list[str] | None, TRIM_OPTION] = None,
    hold_out: Annotated[list[str] | None, HOLD_OUT_OPTION] = None,
    expect: Annotated[list[str] | None, EXPECT_OPTION] = None,
    explain: Annotated[list[str] | None, EXPLAIN_OPTION] = None,
    output: Annotated[Path | None, OUTPUT_OPTION] = None,
    as_json: JsonOption = False,
) -> None:
    """Find where model and measurement disagree, and name what is missing in the model.

    It writes a report, for people and for programs, and the corrected model. On Ctrl-C it writes what is known by then.
    """
    from flexdyn.diagnose.report.result import Interrupted as Partial

    checks, targets = check or [], explain or []
    folder = diagnose_inputs.report_folder(output, [Path(model), *fit, *checks])
    diagnose_inputs.check_twice(fit, checks)
    check_installed("plotly", "plot")  # the report's pictures need it: better said now than after minutes of work
    arm = model_file(model)
    diagnose_inputs.check_targets(arm, targets)
    blocks = [diagnose_inputs.block_of(text) for text in hold_out or ()]
    loaded = trimmed_recordings(load_each([*fit, *checks], maps or ()), trim or ())
    recordings = [loaded[: len(fit)], loaded[len(fit) :]]
    from flexdyn.diagnose import diagnose as run

    done = diagnose_inputs.record_of(model, fit, checks, maps or ())
    try:
        options = {"fit": "FIT", "check": diagnose_inputs.CHECK, "expect": "--expect", "hold_out": "--hold-out"}
        of_model = dict.fromkeys(TOP_KEYS, Path(model))
        with naming(options, file=diagnose_inputs.named(fit), files=of_model):
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
