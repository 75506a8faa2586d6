"""Before a study runs: a trial, which reports an error of every run once, with its key; and checksums of its files."""

from __future__ import annotations

import hashlib
import sys
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from flexdyn.batch.cases import Cases
from flexdyn.checks import check_known
from flexdyn.errors import FlexdynError, InputError
from flexdyn.robot.names import find_robot


def rehearse(cases: Cases) -> None:
    """Prepare the run with every number at its median, then runs with each number at its bounds.

    Args:
        cases: of the study.

    Raises:
        InputError: an unknown path or metric, or a run that cannot be made.
    """
    kinds = cases.study.kinds
    check_paths(cases)
    _ = cases.metrics
    middle = {path: kind.centre for path, kind in kinds.items()}
    try:
        cases.job(cases.case_of(middle))
    except FlexdynError as error:
        cases.job(cases.case_of({}))  # it is reported directly if the varying numbers have no part in it
        key = f"vary.{next(iter(kinds))}" if len(kinds) == 1 else "vary"
        raise InputError(f"a run with every number at its median cannot be made ({error})", key=key) from None
    for path, kind in kinds.items():
        for value in kind.extremes:
            try:
                cases.job(cases.case_of(middle | {path: value}))
            except FlexdynError as error:
                raise InputError(f"a run with {value:g} cannot be made ({error})", key=f"vary.{path}") from None


def check_paths(cases: Cases) -> None:
    """Check that the model or the command has every number that varies.

    Args:
        cases: of the study.

    Raises:
        InputError: an unknown path.
    """
    for path in cases.study.vary:
        if path not in cases.places:
            beside = [each for each in cases.places if each.rpartition(".")[0] == path.rpartition(".")[0]]
            check_known(path, beside or cases.places, "no such number in the model or command", key=f"vary.{path}")


def digests(cases: Cases) -> dict[str, str]:
    """SHA-256 of every file on which a study's runs depend, by its path in the study.

    Args:
        cases: of the study.
    """
    study = cases.study
    files: dict[str, Path] = {}
    source = cases.model.robot.source
    if source is not None:
        files["model.robot.urdf"] = find_robot(source)[0]
    files |= _command_files(study.command)
    for i, name in enumerate(study.metrics):
        if ":" in name:
            place = getattr(sys.modules.get(name.partition(":")[0]), "__file__", None)
            files |= {} if place is None else {f"metrics[{i}]": Path(place)}
    return {key: digest(path) for key, path in files.items()}


def digest(path: Path) -> str:
    """SHA-256 of a file, or of all files of a folder and their names.

    Args:
        path: of either.
    """
    if not path.is_dir():
        with path.open("rb") as stream:
            return hashlib.file_digest(stream, "sha256").hexdigest()
    parts = [f"{file.name} {digest(file)}" for file in sorted(path.iterdir())]
    return hashlib.sha256("\n".join(parts).encode()).hexdigest()


def _command_files(command: Any) -> dict[str, Path]:
    if isinstance(command, str):
        return {"command": Path(command)}
    if isinstance(command, Mapping):
        keys = [key for key in ("reference", "feedforward") if command["pd"].get(key) is not None]
        return {f"command.pd.{key}": Path(command["pd"][key]) for key in keys}
    return {}
