"""study.yaml -> Study: every mistake is one line that names file, key and remedy, before anything runs."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

from flexdyn.batch import study_keys
from flexdyn.batch.cases import Cases, keep, load_command
from flexdyn.batch.distributions import Distribution, Grid
from flexdyn.batch.rehearsal import digests, rehearse
from flexdyn.batch.study import Study
from flexdyn.checks import whole
from flexdyn.control.setting_checks import checked_rate
from flexdyn.errors import InputError, placed
from flexdyn.io.files import exists, is_file
from flexdyn.io.yaml import check_format, read_yaml
from flexdyn.model.flexible_joint_model import FlexibleJointModel
from flexdyn.model.model_file import load_model, model_from_dict, model_to_dict
from flexdyn.simulation.command_input import make_drive
from flexdyn.simulation.inputs_and_signals import SIGNALS

STUDY_FORMAT = 1
TOP_KEYS = ("model", "command", "duration", "rate", "solver", "runs", "seed", "vary", "keep", "metrics", "chunk")
CHUNK_BYTES = 16_000_000
"""Memory of a chunk's runs [bytes]: any machine can hold several chunks."""
CHUNK_RUNS = 256
"""Largest number of runs in a chunk, which are lost if the process is killed."""
CHUNKS = 64
"""Smallest number of chunks, if there are as many runs: enough to give all threads of a machine equal work."""


def read_study(path: str | Path) -> Study:
    """Read a study file; paths in it are relative to it.

    Args:
        path: of the YAML file.

    Raises:
        InputError: no such file, or an entry in it that does not fit.
    """
    file = Path(path)
    with placed(file=file):
        return study_from_dict(read_yaml(file), file.parent)


def study_from_dict(content: Mapping[str, Any], folder: Path) -> Study:
    """Make the study that a file's mapping describes, complete it and try it out.

    Args:
        content: keys of a study file; ``model`` may also be the mapping of a model file.
        folder: its relative paths start here.

    Raises:
        InputError: a key, path, distribution, metric or number that does not fit.
    """
    try:
        return _whole_study(content, folder.resolve())
    except InputError as error:
        of_command = not error.file and str(error.key).startswith("pd.")
        raise (error.at(key="command") if of_command else error) from None
    except OverflowError:
        raise InputError("an integer in it is too large for a double") from None


def _whole_study(content: Mapping[str, Any], folder: Path) -> Study:
    """Check every key of a study file, and rehearse the study."""
    check_format(content, "flexdyn_study", STUDY_FORMAT, TOP_KEYS, required=("model", "vary"))
    if not content.get("keep") and not content.get("metrics"):
        remedy = "name channels under keep, or metrics"
        raise InputError("nothing of the runs would be stored", key="keep", value=content.get("keep"), remedy=remedy)
    model = _model(content["model"], folder)
    command = _command(content.get("command"), folder)
    loaded = load_command(command)
    kinds = study_keys.checked_distributions(content["vary"])
    random = any(isinstance(kind, Distribution) for kind in kinds.values())
    points = math.prod(len(kind.values) for kind in kinds.values() if isinstance(kind, Grid))
    runs = _runs(content.get("runs"), points, random)
    duration = _duration(content.get("duration"), model, loaded)
    rate = checked_rate("rate", content.get("rate", 1000.0))
    study = Study(
        name=model.name,
        model=model_to_dict(model),
        command=command,
        duration=duration,
        rate=rate,
        solver=study_keys.checked_solver(content.get("solver")),
        runs=runs,
        points=points,
        seed=study_keys.checked_seed(content.get("seed", 0)),
        vary={str(path): dict(entry) for path, entry in content["vary"].items()},
        keep=study_keys.checked_channels(content.get("keep")),
        metrics=study_keys.checked_names("metrics", content.get("metrics")),
        chunk=_chunk(content.get("chunk"), points * runs, duration * rate, model.n),
        folder=str(folder),
    )
    cases = Cases(study)
    rehearse(cases)
    cases.study = replace(study, files=digests(cases))
    return keep(cases).study


def _model(entry: Any, folder: Path) -> FlexibleJointModel:
    """The model of a study: written out, or the path or name of one."""
    if isinstance(entry, Mapping):
        with placed(key="model"):
            return model_from_dict(entry, folder)
    if not isinstance(entry, str) or not entry:
        raise InputError("the path of a model file is needed", key="model", value=entry)
    file = folder / entry
    return load_model(file if is_file(file) or file.suffix or "/" in entry else entry)


def _command(entry: Any, folder: Path) -> Any:
    """The command with absolute paths; a YAML file with ``pd:`` is replaced by its content."""
    if entry is None:
        return None
    if isinstance(entry, str) and entry:
        path = _path("command", entry, folder)
        if path.suffix.lower() not in (".yaml", ".yml"):
            return str(path)
        with placed(file=path):
            return {"pd": _pd(read_yaml(path), path.parent, "pd")}
    if isinstance(entry, Mapping):
        return {"pd": _pd(entry, folder, "command.pd")}
    remedy = "give the path of a recording, or a mapping with pd:"
    raise InputError("no such command", key="command", value=entry, remedy=remedy)


def _pd(entry: Any, folder: Path, key: str) -> dict[str, Any]:
    """Settings of the controller, with its recordings' paths absolute."""
    settings = study_keys.checked_pd(entry, key)
    for name in study_keys.RECORDINGS_OF_PD:
        if settings.get(name) is not None:
            settings[name] = str(_path(f"{key}.{name}", settings[name], folder))
    return settings


def _path(key: str, entry: str, folder: Path) -> Path:
    path = folder / entry
    if not exists(path):
        raise InputError("there is no such file", key=key, value=entry, remedy=f"it is looked for in {folder}")
    return path.resolve()


def _runs(given: Any, points: int, random: bool) -> int:
    """Runs at each point of the grid."""
    if random and given is None:
        raise InputError("the number of random draws is missing", key="runs", remedy="write runs: 400")
    runs = 1 if given is None else whole("runs", given, 1)
    if not random and given is not None and runs != points:
        remedy = f"the grid has {points} points, one run each: leave it out"
        raise InputError("nothing is drawn at random", key="runs", value=given, remedy=remedy)
    runs = runs if random else 1
    study_keys.check_number_of_runs(runs, points)
    return runs


def _duration(given: Any, model: FlexibleJointModel, command: Any) -> float:
    if given is None:
        length = make_drive(model, command, None).duration
        if length is None:
            remedy = "give it in s, or a command that has an end"
            raise InputError("the duration is missing", key="duration", remedy=remedy)
        return length
    return study_keys.checked_duration(given)


def _chunk(given: Any, count: int, samples: float, n: int) -> int:
    """Number of runs in a chunk, from the study alone: the store must not depend on the workers."""
    if given is not None:
        return min(whole("chunk", given, 1), count)
    run_bytes = 8 * (samples + 1) * (len(SIGNALS) * n + 1)
    return max(1, min(math.ceil(count / CHUNKS), CHUNK_RUNS, int(CHUNK_BYTES / run_bytes)))
