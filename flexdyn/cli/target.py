"""The meaning of ROBOT or MODEL on the command line."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from flexdyn.errors import InputError, did_you_mean
from flexdyn.model.flexible_joint_model import FlexibleJointModel
from flexdyn.model.model_file import is_robot, load_model, shipped_models
from flexdyn.records.files import is_recording
from flexdyn.robot import load_robot, robot_names

MODEL_SUFFIXES = (".yaml", ".yml")
URDF_SUFFIXES = (".urdf", ".xml")


@dataclass(frozen=True)
class Target:
    """A model, and the kind of its source.

    Attributes:
        model: for a robot the plain model: every joint rigid, only the effects of its URDF.
        taken: ``model file``, ``shipped model``, ``URDF file`` or ``robot``.
    """

    model: FlexibleJointModel
    taken: str


def find(name: str) -> Target:
    """The model of a path or name; if a name is both a robot and a shipped model, the shipped model.

    Raises:
        InputError: an unknown name, or a file with a fault.
    """
    path = Path(name)
    if path.is_file():
        _refuse_recording(path)
        if path.suffix.lower() in MODEL_SUFFIXES:
            return Target(load_model(path), "model file")
        return Target(FlexibleJointModel(load_robot(path)), "URDF file")
    if name in shipped_models():
        return Target(load_model(name), "shipped model")
    if name in robot_names():
        return Target(FlexibleJointModel(load_robot(name)), "robot")
    if path.is_dir():
        _refuse_recording(path)
        raise InputError("it is a folder", file=path, remedy="give the path of a URDF or model.yaml")
    if path.suffix or path.name != name:
        raise InputError("there is no such file", file=name)
    remedy = did_you_mean(name, sorted({*shipped_models(), *robot_names()}))
    raise InputError("neither a file nor a known model or robot", value=name, remedy=remedy)


def model_file(name: str) -> FlexibleJointModel:
    """The model that can be simulated: a model file or a shipped model.

    Raises:
        InputError: it is something else; for a robot the message says how to make a model of it.
    """
    path = Path(name)
    if path.is_file():
        _refuse_recording(path)
    if path.suffix.lower() in URDF_SUFFIXES if path.is_file() else is_robot(name):
        remedy = f"make a model of it: flexdyn new {name} -o {path.stem}.yaml"
        raise InputError("a robot is no model yet", file=name, remedy=remedy)
    return load_model(name)


def _refuse_recording(path: Path) -> None:
    if is_recording(path):
        raise InputError("it is a recording", file=path, remedy="give a model file or a robot")
