"""flexdyn batch: all runs of a study, their results as tables, and the extraction of single runs."""

from __future__ import annotations

import shlex
from dataclasses import fields
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from flexdyn.cli.options import JsonOption, flag, naming, option, output_folder, output_option, picture_file
from flexdyn.cli.output import answer, cell, note, progress, show, show_json, table
from flexdyn.errors import InputError

if TYPE_CHECKING:
    from flexdyn.batch.extract import Extracted
    from flexdyn.batch.summary import Summary

# Arguments of the Python interface -> what the user typed.
OPTION_OF_ARGUMENT = {"workers": "--workers", "scheduler": "--scheduler", "extract": "--extract", "views": "--view"}
METRICS = ("metric", "unit", "runs", "mean", "std", "least", "5 %", "median", "95 %", "greatest", "of run")
REPORT_QUANTILES = (0.05, 0.5, 0.95)
STRONGEST = 3
"""Number of metrics that are listed for each parameter."""


def batch(
    target: Annotated[Path, typer.Argument(metavar="STUDY|OUT", help="A study file to run, or the store of one.")],
    output: Annotated[
        Path | None, output_option("OUT", "The Zarr store to write; with --summary a picture, with --extract a folder.")
    ] = None,
    workers: Annotated[int | None, option("N", "Threads. Default: the processors this process may use.")] = None,
    scheduler: Annotated[
        str | None, option("ADDRESS", "The Dask scheduler whose workers do the runs: tcp://host:8786.")
    ] = None,
    resume: Annotated[bool, flag("--resume", "Continue a store: only missing runs are made.")] = False,
    summary: Annotated[bool, flag("--summary", "Summarise a store, also an incomplete one.")] = False,
    views: Annotated[
        list[str] | None,
        option(
            "NAME", "View in the picture: metrics, sensitivities or trajectories. May be given several times.", "--view"
        ),
    ] = None,
    extract: Annotated[
        int | None, option("K", "Write run K of a store as model file and command, with the line to simulate it.")
    ] = None,
    as_json: JsonOption = False,
) -> None:
    """Run a batch study, or look into the store of one.

    If the process is killed, at most the chunks in progress are lost: --resume continues, and the store then has
    the same bits as after a run without interruption. The store's status says why a run failed; the others
    continue. A metric of your own (package.module:function) is imported: run no study file whose Python you do not
    trust.
    """
    asked = [name for name, given in (("--summary", summary), ("--extract", extract is not None)) if given]
    if len(asked) > 1:
        raise InputError("one at a time", key=" ".join(asked), remedy="leave one of the two out")
    with naming(OPTION_OF_ARGUMENT, file=target, files={}):
        if extract is not None:
            _extract(target, extract, output, as_json)
        elif summary:
            _summarise(target, output, views, as_json)
        else:
            _run_with_progress(target, output, workers, scheduler, resume, as_json)


def _run_with_progress(
    study: Path, output: Path | None, workers: int | None, scheduler: str | None, resume: bool, as_json: bool
) -> None:
    """Run a study, show its progress, and print a summary."""
    from flexdyn.batch.run_study import run_study

    if study.is_dir():
        remedy = "give a study file; of a store --summary or --extract K"
        raise InputError("it is a folder", file=study, remedy=remedy)
    if output is None:
        raise InputError("say where to write", key="--output", remedy="give the path of the store: -o out.zarr")
    with progress(f"{study.name}: starting", lambda reached: f"{study.name}: {reached}") as report:
        try:
            results = run_study(study, output, workers=workers, scheduler=scheduler, resume=resume, progress=report)
        except KeyboardInterrupt:
            if output.exists():
                words = ["flexdyn", "batch", str(study), "-o", str(output), "--resume"]
                note(f"finished runs are stored; continue with: {shlex.join(words)}")
            raise
    try:
        answer(results.summary(), summary_parts, as_json)
    except KeyboardInterrupt:
        note(f"all runs are stored; see them with: {shlex.join(['flexdyn', 'batch', str(output), '--summary'])}")
        raise


def _summarise(store: Path, output: Path | None, views: list[str] | None, as_json: bool) -> None:
    """Print the summary of a store, and draw it if a picture is asked for."""
    from flexdyn.batch.results import open_results

    path = picture_file(output)
    results = open_results(store)
    if path is not None:
        results.plot(path, views=views or None)
    answer(results.summary(), summary_parts, as_json, path)


def _extract(store: Path, k: int, output: Path | None, as_json: bool) -> None:
    """Write one run of a store as a model and its command."""
    from flexdyn.batch.results import open_results

    folder = output_folder(output, "give the path of a folder")
    taken = open_results(store).extract(k, folder)
    if as_json:
        show_json({each.name: getattr(taken, each.name) for each in fields(taken)})
    else:
        show(*extracted_lines(taken))


def summary_parts(summary: Summary) -> list[Any]:
    """Texts and tables of a study's results.

    Args:
        summary: of them.
    """
    pending = summary.runs - summary.done
    head = f"{summary.path}: {summary.done} of {summary.runs} runs done, {summary.failed} of them failed"
    parts: list[Any] = [head + (f"; {pending} to do: --resume" if pending else "")]
    if summary.reasons:
        rows = [(reason.runs, reason.first, reason.text) for reason in summary.reasons]
        parts.append(table("What failed", ("runs", "first", "reason"), rows, right=("runs", "first")))
    if summary.metrics:
        rows_ = [
            (
                each.name,
                each.unit or "-",
                each.runs,
                *map(cell, (each.mean, each.std, each.least)),
                *(cell(each.quantiles.get(share)) for share in REPORT_QUANTILES),
                cell(each.greatest),
                "-" if each.worst is None else each.worst,
            )
            for each in summary.metrics
        ]
        parts.append(table("Metrics", METRICS, rows_, right=METRICS[2:]))
    columns = ("parameter", "unit", "least", "greatest", "rank correlation with metrics")
    varied = [
        (each.name, each.unit or "-", cell(each.least), cell(each.greatest), _correlations(each.sensitivities))
        for each in summary.parameters
    ]
    return [*parts, table("What varies", columns, varied, right=columns[2:4])]


def extracted_lines(taken: Extracted) -> list[Any]:
    """The text for a run that was extracted from a study.

    Args:
        taken: its files and the command line that makes it.
    """
    numbers = [(path, cell(value, 8)) for path, value in taken.values.items()]
    files = ", ".join(str(path) for path in (taken.model, taken.command) if path is not None)
    return [f"run {taken.run} in {files}", table("Drawn", ("number", "value"), numbers, right=("value",)), taken.line]


def _correlations(sensitivities: Any) -> str:
    """The strongest correlations; those that may be chance are in parentheses."""
    shown = []
    for name, each in list(sensitivities.items())[:STRONGEST]:
        text = f"{each.rank_correlation:+.2f}"
        shown.append(f"{name} {text}" if abs(each.rank_correlation) > each.chance else f"{name} ({text})")
    return ", ".join(shown) or "-"
