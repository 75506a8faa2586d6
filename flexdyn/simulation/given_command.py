"""What a user gives as a command: read where it is a path, refused where it is none, and taken from a recording."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from flexdyn.checks import check_known
from flexdyn.control.commands import PD
from flexdyn.control.points import COMMAND_KEYS, command_of
from flexdyn.control.samples import Samples
from flexdyn.errors import InputError, placed
from flexdyn.io.yaml import read_yaml
from flexdyn.model.flexible_joint_model import FlexibleJointModel
from flexdyn.records import Recording, read_recording
from flexdyn.records.given import as_recording
from flexdyn.records.suggestion import asked_back


def check_command(command: Any) -> None:
    """Refuse objects that are similar to a command, with the remedy.

    Raises:
        InputError: a function, with a hint to `Controller`; a robot or model, which belong to another argument.
    """
    if isinstance(command, type):
        remedy = f"give one that is made: {command.__name__}(...)"
        raise InputError("a class is no command", key="command", value=command.__name__, remedy=remedy)
    if callable(command):
        remedy = "wrap it: fd.Controller(law, rate=1000) with law(t, state) -> torques; or sample it: fd.Samples"
        raise InputError("a function is no command by itself", key="command", value=called(command), remedy=remedy)
    if isinstance(command, FlexibleJointModel):
        raise InputError("a model is no command", key="command", remedy="give the model first, then the command")


def called(function: Any) -> str:
    """The name of a function, for a message."""
    return str(getattr(function, "__name__", type(function).__name__))


def resolve_command(command: Any) -> Any:
    """Read a path; return anything else as it is."""
    if type(command).__name__ in ("DataFrame", "Dataset"):
        return as_recording(command, "command")
    if isinstance(command, Mapping) and not command.keys().isdisjoint(COMMAND_KEYS):
        return command_of(command)
    if not isinstance(command, str | Path):
        return command
    if Path(command).suffix.lower() in (".yaml", ".yml"):
        return read_command_file(Path(command))
    return read_recording(command, name=str(command))


def read_command_file(path: Path) -> PD | Samples:
    """Read a YAML file with ``pd:`` or ``torques:``, see `flexdyn.control.points`; its paths are relative to the file.

    Raises:
        InputError: no such file, or an unknown key.
    """
    with placed(file=path):
        return command_of(read_yaml(path), path.parent)


def recorded(recording: Recording, signal: str, joint_names: Sequence[str]) -> Samples:
    """One signal of a recording as held samples; joints that it does not name get zero.

    Raises:
        InputError: the recording has no such signal, or one of a joint that the robot lacks.
    """
    remedy = f"the robot's joints are {', '.join(joint_names)}"
    for joint in recording.joints:
        place = {"key": joint, "file": recording.name or None}
        check_known(joint, joint_names, "the robot has no such joint", remedy=remedy, **place)
    found = [joint for joint in joint_names if recording.has(signal, joint)]
    if not found:
        remedy = asked_back(recording.channels, signal) or f"columns named {signal}.JOINT are needed"
        raise InputError(f"no {signal} in this recording", file=recording.name or None, remedy=remedy)
    return Samples(recording.t, {joint: recording[f"{signal}.{joint}"] for joint in found})


def measured_state(recording: Recording, model: FlexibleJointModel) -> dict[str, dict[str, float]]:
    """The first measured state; for a joint with one encoder, q and theta start with the same value.

    A rigid joint has one position: q, or theta where only that was measured.

    Args:
        recording: whose first samples are taken.
        model: of the arm.

    Returns:
        ``initial`` of a model: values by signal and joint.
    """
    initial: dict[str, dict[str, float]] = {"q": {}, "theta": {}, "v": {}, "omega": {}}
    for name, joint in model.joints.items():
        for signal, twin in (("q", "theta"), ("theta", "q"), ("v", "omega"), ("omega", "v")):
            source = next((each for each in (signal, twin) if recording.has(each, name)), None)
            if source is not None and (joint.elastic or signal in ("q", "v")):
                initial[signal][name] = float(recording[f"{source}.{name}"][0])
    return initial
