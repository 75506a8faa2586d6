"""Checksums of the files that a study reads, so that a store is not continued after one of them changed."""

from __future__ import annotations

import hashlib
import sys
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from flexdyn.batch.cases import Cases
from flexdyn.robot.names import find_robot


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
