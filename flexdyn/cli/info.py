"""flexdyn info: the parts of a robot or model."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import fields
from pathlib import Path
from typing import Annotated, Any

import numpy as np

from flexdyn.cli import modes as cli_modes
from flexdyn.cli.motors import motors
from flexdyn.cli.options import JsonOption, by_joint, flag, model_argument, naming, option, output_file, output_option
from flexdyn.cli.output import cell, show, show_json, table
from flexdyn.cli.target import Target, find
from flexdyn.effects import Effect, InertiaEffect, JointEffect
from flexdyn.errors import InputError
from flexdyn.model.flexible_joint_model import FlexibleJointModel
from flexdyn.model.resolved_parameters import units_of
from flexdyn.plots import SUFFIXES, draw_frequencies
from flexdyn.robot.axes import plain_axes
from flexdyn.simulation.link_side import LinkSide

DRIVES = {
    "J": "rotor inertia",
    "K": "stiffness",
    "D": "damping",
    "q": "position at which the other columns hold",
    "M_ii": "inertia of the arm about the joint",
    "f locked": "frequency of the joint with its rotor held, all other joints rigid",
    "f free": "the same with its rotor free",
}
"""Meanings of the symbols of the drives."""
DRIVE_COLUMNS = ("gear_ratio", "reflected_inertia", "stiffness", "damping", "q", "inertia")
FREQUENCIES = ("locked_rotor_frequency", "free_frequency")


def info(
    target: Annotated[
        str, model_argument("ROBOT|MODEL", "A URDF, a robot's name, a model file or a shipped model's name.")
    ],
    q: Annotated[
        list[str] | None,
        option("VALUES", "Position for M and the frequencies: 0.1,0.2 or elbow=1.57, in rad or m.", "--q"),
    ] = None,
    modes: Annotated[
        bool, flag("--modes", "Eigenfrequencies, damping ratios, shapes and anti-resonances at --q as well.")
    ] = False,
    path: Annotated[Path | None, option("RUN", "With --modes and -o: a recording whose q is the path to draw.")] = None,
    output: Annotated[
        Path | None, output_option("FILE", "Draw the frequencies over --path: .png, .pdf or .svg.")
    ] = None,
    as_json: JsonOption = False,
) -> None:
    """Show what a robot or model is made of: joints, drives, inertias, frequencies, effects.

    A name that a robot and a shipped model share (panda) means the model. M_ii is the inertia about a joint at --q
    with the other joints held; for a rigid joint it includes J. f locked is the frequency with the rotor held,
    sqrt(K/M_ii)/2pi. f free is the frequency with the rotor free. --modes couples all joints, each spring under its
    load at --q.
    """
    picture = _picture(modes, path, output)
    found = find(target)
    pose = by_joint("--q", q or (), found.model.joint_names)
    with naming({"q": "--q"}, file=target, files={}):
        document = model_document(found, pose)
        if modes:
            document["modes"] = cli_modes.modes_document(found.model, pose)
    if picture is not None and path is not None:
        draw_frequencies(cli_modes.along(found.model, path), picture)
    if as_json:
        show_json(document)
        return
    limits = table("Joints", ("joint", "type", "range", "speed", "effort"), found.model.robot.limit_rows())
    show(_head(document), limits, _drives(document), motors(document["joints"]))
    show(_axes(document), _followers(document), _effects_table(document))
    if modes:
        show(*cli_modes.tables(document["modes"], {joint["name"]: joint["elastic"] for joint in document["joints"]}))
    if picture is not None:
        show(f"frequencies over the path drawn in {picture}")


def _picture(modes: bool, path: Path | None, output: Path | None) -> Path | None:
    """The picture to draw, if one is asked for.

    Raises:
        InputError: --modes, --path and --output are not given together.
    """
    if path is None and output is None:
        return None
    for name, given in (("--modes", modes), ("--path", path), ("--output", output)):
        if not given:
            remedy = "a picture of frequencies needs --modes --path RUN -o FILE"
            raise InputError("it is missing", key=name, remedy=remedy)
    return output_file("--output", output, SUFFIXES, inputs=(path,))


def model_document(found: Target, q: Mapping[str, float]) -> dict[str, Any]:
    """The content of `info`, as in the JSON document.

    Args:
        found: robot or model.
        q: positions by joint over the model's initial ones [rad or m].
    """
    model = found.model
    robot = model.robot
    at = {**dict.fromkeys(model.joint_names, 0.0), **model.initial.get("q", {}), **q}
    M = LinkSide(model).mass_matrix(np.array(list(at.values())))
    return {
        "name": model.name,
        "taken": found.taken,
        "robot": str(robot.source),
        "gravity": model.gravity,
        "tip": _tip(model),
        "moving_mass": float(sum(inertia.mass for inertia in robot.pin_model.inertias[1:])),
        "payload": float(sum(effect.point_mass[1] for effect in model.effects if isinstance(effect, InertiaEffect))),
        "tolerance": model.tolerance,
        "joints": [_joint(model, j, at[name], float(M[j, j])) for j, name in enumerate(model.joint_names)],
        "mass_matrix": M,
        "followers": {name: list(entry) for name, entry in robot.followers.items()},
        "axes": plain_axes(robot.axes),
        "lock": robot.lock,
        "effects": [_effect(model, effect, f"effects[{i}]") for i, effect in enumerate(model.effects)]
        + [_effect(model, effect, "URDF") for effect in model.urdf_effects],
    }


def _joint(model: FlexibleJointModel, j: int, q: float, inertia: float) -> dict[str, Any]:
    """The entry of a joint: its limits, its drive, and the frequencies of its spring at this position."""
    robot, name = model.robot, model.joint_names[j]
    drive = model.joints[name]
    J = drive.reflected_inertia
    moving = drive.elastic and inertia > 0
    return {
        "name": name,
        "type": "continuous" if robot.continuous[j] else robot.kinds[j],
        "unit": robot.angle_unit(j),
        "lower": float(robot.lower[j]),
        "upper": float(robot.upper[j]),
        "velocity_limit": float(robot.velocity_limit[j]),
        "effort_limit": float(robot.effort_limit[j]),
        "elastic": drive.elastic,
        **drive.values(),
        "actuator": None if drive.actuator is None else drive.actuator.to_dict(),
        "reflected_inertia": J,
        "q": q,
        "inertia": inertia,
        "locked_rotor_frequency": math.sqrt(drive.stiffness / inertia) / math.tau if moving else None,
        "free_frequency": math.sqrt(drive.stiffness * (1 / inertia + 1 / J)) / math.tau if moving else None,
    }


def _effect(model: FlexibleJointModel, effect: Effect, origin: str) -> dict[str, Any]:
    """The entry of an effect: where it acts, its numbers with units, and where it comes from."""
    joint = effect.joint if isinstance(effect, JointEffect) else None
    units = units_of(model.robot, effect)
    numbers = {name: {"value": getattr(effect, name), "unit": unit} for name, unit in units.items()}
    known = {"joint", "side", *numbers}
    others = {f.name: getattr(effect, f.name) for f in fields(effect) if f.name not in known}  # type: ignore[arg-type]
    return {
        "effect": effect.name,
        "joint": joint,
        "side": getattr(effect, "side", None),
        "parameters": numbers,
        **others,
        "from": origin,
        "neutral": effect.is_neutral,
    }


def _tip(model: FlexibleJointModel) -> str | None:
    try:
        return model.robot.tip
    except InputError:  # a branched arm has several ends
        return None


def _head(document: Mapping[str, Any]) -> str:
    """What the model is: its robot, joints, mass, gravity, tip frame and locked joints."""
    elastic = sum(joint["elastic"] for joint in document["joints"])
    payload = f" and {cell(document['payload'])} kg payload" if document["payload"] else ""
    lines = [
        f"{document['name']}, taken for a {document['taken']}; robot: {document['robot']}",
        f"{len(document['joints'])} joints, {elastic} elastic",
        f"moving mass: {cell(document['moving_mass'])} kg{payload}",
        f"gravity: {list(document['gravity'])} m/s^2",
        f"tip frame: {document['tip'] or 'none, the arm is branched'}",
    ]
    if document["lock"]:
        lines.append("locked: " + ", ".join(f"{name} at {cell(value)}" for name, value in document["lock"].items()))
    return "\n".join(lines)


def _drives(document: Mapping[str, Any]) -> Any:
    """The table of the drives: their numbers, and the frequencies of their springs."""
    columns = ("joint", "drive", "gear", "J", "K", "D", "q", "M_ii", "f locked", "f free")
    rows = [
        (
            joint["name"],
            "elastic" if joint["elastic"] else "rigid",
            *(cell(joint[key]) for key in DRIVE_COLUMNS),
            *("-" if joint[key] is None else f"{cell(joint[key])} Hz" for key in FREQUENCIES),
        )
        for joint in document["joints"]
    ]
    title = "Drives, on the link side (SI: rad, N m, kg m^2; prismatic: m, N, kg)"
    return table(title, columns, rows, right=columns[2:], legend=DRIVES)


def _axes(document: Mapping[str, Any]) -> Any:
    rows = [
        (axis, " + ".join(f"{cell(value)} {joint}" for joint, value in entry.items()))
        for axis, entry in document["axes"].items()
    ]
    return table("Axes of coupled drives", ("axis", "is"), rows) if rows else None


def _followers(document: Mapping[str, Any]) -> Any:
    rows = [
        (name, leader, cell(factor), cell(offset)) for name, (leader, factor, offset) in document["followers"].items()
    ]
    return table("Mimic joints", ("joint", "follows", "times", "plus"), rows, right=("times", "plus")) if rows else None


def _effects_table(document: Mapping[str, Any]) -> Any:
    rows = []
    for effect in document["effects"]:
        numbers = [f"{key} {cell(entry['value'])} {entry['unit']}" for key, entry in effect["parameters"].items()]
        frame = [f"frame {effect['frame']}"] if effect.get("frame") else []
        place = (effect["joint"] or "-", effect["side"] or "-")
        nothing = " (neutral: it changes nothing)" if effect["neutral"] else ""
        rows.append((effect["from"], effect["effect"], *place, ", ".join(numbers + frame) + nothing))
    return table("Effects", ("from", "effect", "joint", "side", "parameters"), rows) if rows else "Effects: none"
