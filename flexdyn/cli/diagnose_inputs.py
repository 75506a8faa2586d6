"""What `flexdyn diagnose` finds out about its arguments before any work is done."""

from __future__ import annotations

import shlex
import sys
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from flexdyn.cli.options import naming, output_folder, span_of
from flexdyn.cli.recordings import files_beside
from flexdyn.errors import InputError

if TYPE_CHECKING:
    from flexdyn.diagnose.report.origin import Record
    from flexdyn.model.flexible_joint_model import FlexibleJointModel

CHECK, EXPLAIN = "--check", "--explain"
"""Options whose names stand in errors too."""


def block_of(text: str) -> tuple[float, float]:
    """A block that is kept apart: both ends are needed."""
    first, last = span_of("--hold-out", text)
    if first is None or last is None:
        raise InputError("a block has a first and a last time", key="--hold-out", value=text, remedy="give both, in s")
    return first, last


def record_of(model: str, fit: Sequence[Path], check: Sequence[Path], maps: Sequence[Path]) -> Callable[[], Record]:
    """What is told of the command and its files once it is done; files as they are now, before anything is read."""
    from flexdyn.diagnose.report.origin import File, record

    uses = [(Path(model), "model"), *((path, "fit") for path in fit), *((path, "test") for path in check)]
    uses += [(each, "channel map") for each in maps]
    files = [File.of(part, use) for path, use in uses for part in files_beside(path)]
    return lambda: record(shlex.join(["flexdyn", *sys.argv[1:]]), files)


def check_targets(model: FlexibleJointModel, targets: Sequence[str]) -> None:
    """What is to be explained exists: better said now than after the work."""
    from flexdyn.diagnose.report.explain import check_target

    with naming({"explain": EXPLAIN}, file="", files={}):
        for target in targets:
            check_target(model, target)


def report_folder(path: Path | None, inputs: Sequence[Path]) -> Path:
    """The folder to write to, found fit before any work is done."""
    path = output_folder(path, "give a folder for the report")
    for name in ("model.yaml", "report.json", "report.html"):
        for given in inputs:
            if (path / name).exists() and given.exists() and given.samefile(path / name):
                remedy = "write to another folder"
                raise InputError("the command reads this file", file=given, key="--output", remedy=remedy)
    return path


def check_twice(fit: Sequence[Path], check: Sequence[Path]) -> None:
    """Data that check an answer may not have given it."""
    for path in check:
        if any(path.exists() and other.exists() and path.samefile(other) for other in fit):
            remedy = "give another recording, or none: then the last fifth of every one is kept for the test"
            raise InputError("it is one of FIT too", file=path, key=CHECK, remedy=remedy)


def named(paths: Sequence[Path]) -> str:
    """Files as an error names them: the first three, and how many more."""
    return ", ".join(map(str, paths[:3])) + (f" and {len(paths) - 3} more" if len(paths) > 3 else "")
