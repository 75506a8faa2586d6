"""Extract one run of a study: its model file, its command, and the command line that repeats this run."""

from __future__ import annotations

import shlex
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from flexdyn.batch.cases import cases_of
from flexdyn.batch.draws import draws_of_run
from flexdyn.batch.rehearsal import check_paths
from flexdyn.batch.study import Study
from flexdyn.checks import whole
from flexdyn.control.commands import PD
from flexdyn.errors import InputError
from flexdyn.io.files import make_folder, write_text
from flexdyn.io.yaml import dump_yaml
from flexdyn.model.model_file import save_model
from flexdyn.records import Recording, write_recording

OPTIONS = ("step", "rtol", "atol", "smoothing")
"""Settings of solvers that ``flexdyn simulate`` takes."""


@dataclass(frozen=True)
class Extracted:
    """A run that was extracted from a study.

    Attributes:
        run: its number.
        model: path of its model file.
        command: path of its command file; None: no torque.
        values: the numbers that were drawn for it, by their path.
        line: command line of ``flexdyn simulate`` that makes it.
    """

    run: int
    model: Path
    command: Path | None
    values: Mapping[str, float]
    line: str


def extract(study: Study, k: int, folder: Path) -> Extracted:
    """Write the files of one run.

    Args:
        study: that has the run.
        k: its number, from 0.
        folder: to write them to; it is created if it does not exist.

    Raises:
        InputError: there is no such run, a model cannot have its numbers, or the folder cannot be written.
    """
    last = study.count - 1
    whole("extract", k, 0, last, problem="there is no such run", remedy=f"runs are 0 to {last}")
    cases = cases_of(study)
    check_paths(cases)  # the study may be that of a store from elsewhere
    case = cases.case(k)
    settings = _settings(study.solver)
    make_folder(folder)
    model, command = folder / "model.yaml", _write_command(case.command, folder)
    save_model(case.model, model)
    words = ["flexdyn", "simulate", str(model)]
    words += ["--command", str(command)] if command is not None else []
    words += ["--duration", repr(study.duration), "--rate", repr(study.rate), *settings]
    for signal, start in case.starts.items():
        words += [f"--{signal}", ",".join(f"{joint}={float(value)!r}" for joint, value in start.items())]
    words += ["-o", str(folder / "run.npz")]
    return Extracted(k, model, command, draws_of_run(study, k), shlex.join(words))


def _settings(solver: Mapping[str, Any]) -> list[str]:
    words = ["--solver", str(solver["name"])]
    for name, value in solver.items():
        if name in OPTIONS:
            words += [f"--{name}", repr(float(value))]
        elif name != "name":
            remedy = "simulate it in Python: fd.simulate(..., solver=...)"
            raise InputError("flexdyn simulate does not take this setting", key=f"solver.{name}", remedy=remedy)
    return words


def _write_command(command: Any, folder: Path) -> Path | None:
    """The command as a file for ``flexdyn simulate``; the files that it reads are in the same folder."""
    if command is None:
        return None
    if isinstance(command, Recording):
        write_recording(command, folder / "command.npz")
        return folder / "command.npz"
    if not isinstance(command, PD):
        raise InputError("this command cannot be written as a file", key="command", value=command)
    entry: dict[str, Any] = {"kp": _plain(command.kp), "kd": _plain(command.kd)}
    entry |= {"rate": command.rate, "feedback": command.feedback}
    if command.interpolation is not None:
        entry["interpolation"] = command.interpolation
    for key in ("reference", "feedforward"):
        given = getattr(command, key)
        if given is not None:
            write_recording(given, folder / f"{key}.npz")
            entry[key] = f"{key}.npz"
    write_text(folder / "command.yaml", dump_yaml({"pd": entry}))
    return folder / "command.yaml"


def _plain(gains: Any) -> Any:
    """Gains in a form for YAML."""
    if isinstance(gains, Mapping):
        return {str(joint): float(value) for joint, value in gains.items()}
    return np.asarray(gains, dtype=float).tolist()
