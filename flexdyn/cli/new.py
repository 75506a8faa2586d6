"""flexdyn new: a commented model file for any robot."""

from __future__ import annotations

import math
import re
import warnings
from pathlib import Path
from typing import Annotated

from flexdyn.cli.options import flag, model_argument, output_file, output_option
from flexdyn.cli.output import number, show
from flexdyn.cli.target import MODEL_SUFFIXES
from flexdyn.effects import JointCoupling, catalogue, unit_for
from flexdyn.errors import InputError
from flexdyn.io.files import write_text
from flexdyn.io.yaml import parse_yaml
from flexdyn.model.flexible_joint_model import FlexibleJointModel
from flexdyn.model.model_file import model_from_dict, model_to_dict
from flexdyn.plots import example_entry
from flexdyn.robot import load_robot
from flexdyn.simulation.plant import LinkSide

_PLAIN = re.compile(r"(\.\.?/)*[A-Za-z_/][A-Za-z0-9_./-]*")
SUGGESTED_BANDWIDTH = 2.0
"""Bandwidth of the controller of the suggested motion [Hz]."""
_WORDS = ("null", "true", "false", "yes", "no", "on", "off", "y", "n")


def new(
    robot: Annotated[
        str,
        model_argument("ROBOT", "A URDF, or a robot's name."),
    ],
    output: Annotated[Path | None, output_option("FILE", "The model file to write, .yaml.")] = None,
    force: Annotated[bool, flag("--force", "Overwrite the file if it is there.")] = False,
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
    return "\n".join([*_head(model, folder), *_joints(model), *_tail(model), *_command(model), *_effects(model)]) + "\n"


def quoted(text: str) -> str:
    """A text in YAML, in double quotes if it needs them."""
    if _PLAIN.fullmatch(text) and text.lower() not in _WORDS:
        return text
    letters = []
    for letter in text:
        if letter in '"\\':
            letters.append(f"\\{letter}")
        elif letter.isprintable():
            letters.append(letter)
        else:
            letters.append(f"\\U{ord(letter):08x}")
    return f'"{"".join(letters)}"'


def _head(model: FlexibleJointModel, folder: Path) -> list[str]:
    entry = model_to_dict(model, folder)["robot"]
    first = quoted(model.joint_names[0])
    gravity = ", ".join(repr(component) for component in model.gravity)
    return [
        f"# {quoted(model.name)}: a flexdyn model, every joint rigid as yet. SI units: rad, N m, kg m^2, s,",
        "# on a prismatic joint m, N, kg. rotor_inertia is on the motor side of the gear, all else on the link side.",
        "flexdyn: 1  # version of this format",
        "robot:",
        f"  urdf: {quoted(entry['urdf'])}  # a path relative to this file, or the name of a known robot",
        "  # package_dirs: [meshes]  # folders of package:// meshes",
        f"  gravity: [{gravity}]  # m/s^2, in the axes of the base",
        f"  # lock: {{{first}: 0.0}}  # joints to remove, held at these positions",
        "  # axes: {left: {pitch: 1.0, roll: 1.0}, right: {pitch: 1.0, roll: -1.0}}  # of drives of several joints",
        f"  urdf_dynamics: {model.urdf_dynamics}  # or ignore: <dynamics> of the URDF, here {_dynamics(model)}",
        f"  rotor_coupling: {model.rotor_coupling}  # or full: rotors ride on links, their spin acts on them",
    ]


def _dynamics(model: FlexibleJointModel) -> str:
    return f"{len(model.urdf_effects)} effects" if model.urdf_effects else "none"


def _joints(model: FlexibleJointModel) -> list[str]:
    M = LinkSide(model).mass_matrix([0.0] * model.n)
    lines = [
        "# To make a joint elastic, give it a stiffness and a rotor_inertia above 0. Typical of a robot's joint:",
        "#   gear_ratio     50 to 160 for a harmonic drive, 1 for direct drive",
        "#   rotor_inertia  1e-5 to 1e-4 for a motor of 100 to 750 W with its wave generator; times gear_ratio^2 it is",
        "#                  about what the joint turns (M_ii)",
        "#   stiffness      3e3 to 5e4 for a harmonic drive of size 14 to 32; .inf is rigid",
        "#   damping        2 to 10 % of critical: 2*0.05*sqrt(stiffness*M_ii) is 5 %",
        '# A joint that is not named takes what stands under "*", or the numbers given here.',
        "joints:",
    ]
    for j, name in enumerate(model.joint_names):
        lines += _joint(model, j, name, float(M[j, j]))
    if model.robot.followers:
        lines.append(f"  # mimic joints follow their leaders: {', '.join(map(quoted, model.robot.followers))}")
    return lines


def _joint(model: FlexibleJointModel, j: int, name: str, inertia: float) -> list[str]:
    robot = model.robot
    unit, torque = robot.angle_unit(j), robot.torque_unit(j)
    mass = "kg m^2" if unit == "rad" else "kg"
    kind = "continuous" if robot.continuous[j] else robot.kinds[j]
    ends = f"{number(float(robot.lower[j]))} to {number(float(robot.upper[j]))} {unit}"
    span = "without limits" if math.isinf(robot.upper[j] - robot.lower[j]) else ends
    outside = "" if robot.lower[j] <= 0.0 <= robot.upper[j] else ", 0 is outside"
    turned = "angle" if unit == "rad" else "position [rad/m]"
    drive = model.joints[name]
    return [
        f"  {quoted(name)}:  # {kind}, {span}{outside}; M_ii = {number(inertia)} {mass} at q = 0",
        f"    gear_ratio: {drive.gear_ratio!r}  # motor angle / joint {turned}",
        f"    rotor_inertia: {drive.rotor_inertia!r}  # kg m^2, motor side; or unknown: a diagnosis estimates it",
        f"    stiffness: .inf  # {torque}/{unit}; 10 Hz with the rotor held would be {_stiffness(inertia)}",
        f"    damping: {drive.damping!r}  # {torque} s/{unit}, across the transmission",
    ]


def _stiffness(inertia: float) -> str:
    """The stiffness K with sqrt(K/M_ii)/2pi = 10 Hz."""
    return f"{float(f'{(math.tau * 10.0) ** 2 * inertia:.2g}'):g}"


def _tail(model: FlexibleJointModel) -> list[str]:
    first = quoted(model.joint_names[0])
    return [
        f"initial: {{}}  # first state, for example {{q: {{{first}: 0.1}}}}; also v, theta, omega",
        f"tolerance: {model.tolerance!r}  # how well the numbers are known: relative, 1 sigma",
    ]


def _command(model: FlexibleJointModel) -> list[str]:
    """A motion as a comment: the first joint moves there and back, with gains that fit the inertia of each joint."""
    robot, names = model.robot, list(map(quoted, model.joint_names))
    M = LinkSide(model).mass_matrix([0.0] * model.n)
    low, high = float(robot.lower[0]), float(robot.upper[0])
    span = min(high - low, 2.0)
    start = 0.0 if low <= 0.0 < high else low + 0.25 * span
    goal = start + 0.25 * min(span, high - start)
    unit, torque = robot.angle_unit(0), robot.torque_unit(0)
    turn = math.tau * SUGGESTED_BANDWIDTH
    kp, kd = (
        ", ".join(f"{name}: {float(f'{factor * M[j, j]:.2g}'):g}" for j, name in enumerate(names))
        for factor in (turn**2, 1.4 * turn)
    )
    return [
        "# What flexdyn simulate does with this file alone; without it, and without --command, there is no torque:",
        "# command:",
        "#   pd:  # tracking; or torques: {t: [0, 1], ...}",
        f"#     reference: {{t: [0, 1, 2], {names[0]}: [{start:.4g}, {goal:.4g}, {start:.4g}]}}  # {unit}; others stay",
        f"#     kp: {{{kp}}}  # {torque}/{unit}, by M_ii for {SUGGESTED_BANDWIDTH:g} Hz",
        f"#     kd: {{{kd}}}  # {torque} s/{unit}",
    ]


def _effects(model: FlexibleJointModel) -> list[str]:
    """A commented line for every effect of the catalogue."""
    first, *others = model.joint_names
    prismatic = model.robot.kinds[0] == "prismatic"
    lines = [
        "# Any number of effects; several of one kind add up. Those of a transmission, and those of its load",
        "# tau_s, need an elastic joint, joint_elasticity a rigid one whose rotor has inertia.",
        "effects:",
    ]
    for kind in catalogue().values():
        if kind is JointCoupling and not others:
            continue
        entry = example_entry(kind, first, *others[:1])
        units = {field.name: unit_for(field.metadata["unit"], prismatic=prismatic) for field in kind.parameters()}
        legend = ", ".join(f"{key} {unit}" for key, unit in units.items() if unit != "1")
        values = ", ".join(
            f"{key}: {quoted(value) if isinstance(value, str) else value}" for key, value in entry.items()
        )
        lines.append(f"  # - {{{values}}}" + (f"  # {legend}" if legend else ""))
    return lines
