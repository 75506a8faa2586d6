"""flexdyn new: a commented model file for any robot."""

from __future__ import annotations

import math
import re
import warnings
from collections.abc import Iterator
from pathlib import Path
from typing import Annotated

from flexdyn.cli.options import flag, model_argument, output_file, output_option
from flexdyn.cli.output import cell, show
from flexdyn.cli.target import MODEL_SUFFIXES
from flexdyn.effects import catalogue
from flexdyn.errors import InputError
from flexdyn.io.files import write_text
from flexdyn.io.text import fill
from flexdyn.io.yaml import parse_yaml
from flexdyn.model.flexible_joint_model import FlexibleJointModel
from flexdyn.model.model_file import model_from_dict, model_to_dict
from flexdyn.plots import example_entry
from flexdyn.robot import load_robot
from flexdyn.simulation.link_side import LinkSide

_PLAIN = re.compile(r"(\.\.?/)*[A-Za-z_/][A-Za-z0-9_./-]*")
SUGGESTED_BANDWIDTH = 2.0
"""Bandwidth of the controller of the suggested motion [Hz]."""
_WORDS = ("null", "true", "false", "yes", "no", "on", "off", "y", "n")


def new(
    robot: Annotated[str, model_argument("ROBOT", "A URDF, or a robot's name.")],
    output: Annotated[Path | None, output_option("FILE", "The model file to write, .yaml.")] = None,
    force: Annotated[bool, flag("--force", "Overwrite an existing file.")] = False,
) -> None:
    """Write a commented model file of a robot.

    Every joint is rigid in it; its comments say how to give it a spring, a rotor and friction.
    """
    path = output_file("--output", output, MODEL_SUFFIXES, inputs=(Path(robot),))
    if path.exists() and not force:
        raise InputError("the file exists", file=path, key="--output", remedy="give --force to overwrite it")
    if Path(robot).is_file() and Path(robot).suffix.lower() in MODEL_SUFFIXES:
        raise InputError("it is a model file already", file=robot, remedy="give a URDF or a robot's name")
    model = FlexibleJointModel(load_robot(robot))
    text = model_text(model, path.parent)
    # The written file must be loadable from its folder.
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # load_robot has said it
        model_from_dict(parse_yaml(text, path), path.parent, name=model.name)
    write_text(path, text)
    show(f"{path}: {model.n} rigid joints of {model.name}; its comments say how to make them elastic")


def model_text(model: FlexibleJointModel, folder: Path) -> str:
    """The text of a model file with comments about all possible entries.

    Args:
        model: the plain model of a robot.
        folder: of the file; paths are relative to it.
    """
    M = LinkSide(model).mass_matrix([0.0] * model.n)
    names, turn = list(map(quoted, model.joint_names)), math.tau * SUGGESTED_BANDWIDTH
    kp, kd = (
        ", ".join(f"{name}: {_two_digits(factor * M[j, j])}" for j, name in enumerate(names))
        for factor in (turn**2, 1.4 * turn)
    )
    text = fill(
        "cli/new_model.yaml",
        model=model,
        urdf=model_to_dict(model, folder)["robot"]["urdf"],
        first=names[0],
        dynamics=f"{len(model.urdf_effects)} effects" if model.urdf_effects else "none",
        robot=model.robot,
        inertias=dict(zip(model.joint_names, M.diagonal().tolist(), strict=True)),
        followers=list(map(quoted, model.robot.followers)),
        motion=[f"{position:.4g}" for position in _motion(model)],
        kp=kp,
        kd=kd,
        bandwidth=f"{SUGGESTED_BANDWIDTH:g}",
        effects=list(_effect_entries(model)),
        quoted=quoted,
        number=cell,
        two_digits=_two_digits,
        isinf=math.isinf,
        pi=math.pi,
    )
    return text.rstrip("\n") + "\n"


def quoted(text: str) -> str:
    """A text in YAML, in double quotes if it needs them."""
    if _PLAIN.fullmatch(text) and text.lower() not in _WORDS:
        return text
    escaped = text.replace("\\", r"\\").replace('"', r"\"")
    letters = (x if x.isprintable() else f"\\U{ord(x):08x}" for x in escaped)
    return f'"{"".join(letters)}"'


def _two_digits(value: float) -> str:
    return f"{float(f'{value:.2g}'):g}"


def _motion(model: FlexibleJointModel) -> tuple[float, float, float]:
    """Positions of the first joint in the suggested motion: there and back, within its limits."""
    low, high = float(model.robot.lower[0]), float(model.robot.upper[0])
    span = min(high - low, 2.0)
    start = 0.0 if low <= 0.0 < high else low + 0.25 * span
    return start, start + 0.25 * min(span, high - start), start


def _effect_entries(model: FlexibleJointModel) -> Iterator[tuple[str, str]]:
    """An entry and its units for every effect of the catalogue."""
    first, *others = model.joint_names
    prismatic = model.robot.kinds[0] == "prismatic"
    for kind in catalogue().values():
        entry = example_entry(kind, first, *others[:1])
        if "other" in entry and not others:
            continue
        units = kind.units(prismatic=prismatic)
        values = (f"{key}: {quoted(value) if isinstance(value, str) else value}" for key, value in entry.items())
        yield ", ".join(values), ", ".join(f"{key} {unit}" for key, unit in units.items() if unit != "1")
